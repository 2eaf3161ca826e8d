"""STL files as programs write them: white space, names, counts, trailing bytes."""

import struct

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.meshes.stl import read_stl
from gpu.scene.remarks import Remarks

FACET = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n"
TEXT = f"solid part\n{FACET}{FACET}endsolid part\n"
RECORD = struct.pack("<12fH", *(0, 0, 1), *(0, 0, 0), *(1, 0, 0), *(0, 1, 0), 0)


def binary(count: int, body: bytes, header: bytes = b"") -> bytes:
    return header.ljust(80, b"\0") + struct.pack("<I", count) + body


@pytest.mark.parametrize(
    "text",
    [
        TEXT,
        TEXT.upper(),
        TEXT.replace(" ", "\t"),
        TEXT.replace("facet ", "facet  "),
        TEXT.replace("\n", "\r"),
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", " ").replace("  ", " \f"),
        TEXT.replace("endloop", "end loop").replace("endfacet", "end facet").replace("endsolid", "end solid"),
        "\n " + TEXT,
        TEXT.replace("solid part", "solid bracket facet normal vertex v2"),
        TEXT.replace("solid part", "solid"),
        TEXT.replace("endsolid part\n", ""),
        "solid a\n" + FACET + "endsolid a\nsolid b\n" + FACET + "endsolid b\n",
        TEXT.replace("outer loop", "outer loop\n; vertex 1 2 3\n# note\n// note"),
        TEXT.replace("1 0 0", "1.0E+00 0e0 -0"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_text_in_any_shape(text: str, encoding: str) -> None:
    remarks = Remarks()
    part = read_stl("a.stl", text.encode(encoding), remarks)
    assert part.positions[part.triangles].tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]] * 2
    assert remarks.sentences() == ()


def test_names_in_any_encoding() -> None:
    assert len(read_stl("a.stl", TEXT.replace("part", "Stütze ß").encode("cp1252"), Remarks()).triangles) == 2


@pytest.mark.parametrize(
    ("content", "facets", "says"),
    [
        (binary(2, RECORD * 2, b"solid exported"), 2, ()),
        (binary(2, RECORD * 2, b"solid facet vertex normal"), 2, ()),
        (binary(0, RECORD * 2), 2, ("the header says 0 facets: all 2 that follow were taken",)),
        (binary(2**32 - 1, RECORD * 2), 2, ("the header says 4,294,967,295 facets: all 2 that follow were taken",)),
        (binary(2, RECORD * 2 + b"\n" * 37), 2, ("bytes after the last facet were ignored (37)",)),
        (binary(1, RECORD * 2), 1, ("bytes after the last facet were ignored (50)",)),
        (binary(1, RECORD[:-2] + b"\1\2", "Größe COLOR=".encode("cp1252")), 1,
         ("facets have an attribute, a colour of some programs, that was ignored (1)",
          "the colour in the header was ignored")),
    ],
)  # fmt: skip
def test_binary_files_with_odd_headers(content: bytes, facets: int, says: tuple[str, ...]) -> None:
    remarks = Remarks()
    assert len(read_stl("a.stl", content, remarks).triangles) == facets
    assert remarks.sentences() == says


def test_a_facet_that_nobody_can_see_is_left_to_be_dropped_and_normals_against_the_order_are_said() -> None:
    remarks = Remarks()
    text = TEXT.replace("normal 0 0 1", "normal nan 0 0", 1).replace("normal 0 0 1", "normal 0 0 -1")
    part = read_stl("a.stl", text.encode(), remarks)
    assert (part.normals, len(part.triangles)) == (None, 2)
    assert remarks.sentences() == ("facets have a normal against the order of their corners, which counts (1)",)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (TEXT.replace("1 0 0", "1,0 0 0").encode(), "a vertex or a normal is not 3 numbers with points for decimals"),
        (TEXT.replace("vertex 1 0 0", "vertex 1 0").encode(), "a vertex or a normal is not 3 numbers"),
        (TEXT.replace("vertex 1 0 0", "vertex nan 0 0").encode(), "facet 0: is not finite"),
        (TEXT[:-30].encode(), "facet 2: a facet does not end; the file is cut off"),
        (binary(2, RECORD * 2)[:-1], "2 facets, but only 1 follow; the file is cut off"),
        (b"solid", "not an STL file"),
        (b"", "not an STL file"),
    ],
)
def test_what_is_broken_is_refused(content: bytes, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_stl("a.stl", content, Remarks())
    assert says in str(caught.value)


def test_a_facet_of_two_corners_is_left_out() -> None:
    remarks = Remarks()
    part = read_stl("a.stl", TEXT.replace("  vertex 1 0 0\n", "", 1).encode(), remarks)
    assert np.array_equal(part.positions[part.triangles], [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    assert remarks.sentences() == ("faces with fewer than 3 corners were left out (1)",)
