"""OFF files: keywords, colours, text and binary."""

import struct

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.meshes.off import read_off
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart

RED = (0.7913, 0.0130, 0.0070, 1.0)  # of 230 30 20
BODY = "3 1 0\n0 0 0{0}\n1 0 0{0}\n0 1 0{0}\n3 0 1 2{1}\n"


def read(text: str | bytes) -> tuple[MeshPart, tuple[str, ...]]:
    remarks = Remarks()
    part = read_off("a.off", text.encode() if isinstance(text, str) else text, remarks)
    assert part.positions[part.triangles].tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    return part, remarks.sentences()


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n" + BODY.format("", ""),
        "off " + BODY.format("", ""),
        BODY.format("", ""),
        "OFF # a comment\n\n# one\n" + BODY.format("\t# v", " # f").replace(" ", "\t"),
        "OFF\n" + " ".join(BODY.format("", "").split()),
        "OFF\n3 1 0\n0 0 0 1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF 3\n1\n0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "\ufeffOFF\r\n" + BODY.format("", "").replace("\n", "\r\n"),
    ],
)
def test_plain_files(text: str) -> None:
    part, says = read(text)
    assert (part.colors, part.normals, says) == (None, None, ())


@pytest.mark.parametrize(
    "text",
    [
        "COFF\n" + BODY.format(" 230 30 20 255", ""),
        "COFF\n" + BODY.format(" 0.902 0.1176 0.0784 1", ""),
        "OFF\n" + BODY.format(" 230 30 20", ""),
        "OFF\n" + BODY.format("", " 230 30 20"),
        "OFF\n" + BODY.format("", " 0.902 0.1176 0.0784 1.0"),
        "CNOFF\n" + BODY.format(" 0 0 1 230 30 20 255", ""),
    ],
)
def test_colours_of_vertices_and_faces(text: str) -> None:
    part, says = read(text)
    assert part.colors is not None
    assert np.allclose(part.colors, RED, atol=1e-3)
    assert (says, part.normals is not None) == ((), text.startswith("CN"))


def test_what_is_not_used_is_said() -> None:
    assert read("STOFF\n" + BODY.format(" 0.5 0.5", " 7"))[1] == (
        "faces have an entry of a colour map, or other numbers, that was ignored (1)",
        "texture coordinates or other numbers of vertices were ignored",
    )
    assert read("OFF\n" + BODY.format("", "") + "2 0 1\n")[1] == ("lines after the last face were ignored (1)",)


@pytest.mark.parametrize("colors", [(), (0.902, 0.1176, 0.0784)])
def test_binary_files(colors: tuple[float, ...]) -> None:
    body = struct.pack(">3i9f4i", 3, 1, 0, *(0, 0, 0), *(1, 0, 0), *(0, 1, 0), 3, 0, 1, 2)
    part, _ = read(b"OFF BINARY\n" + body + struct.pack(f">i{len(colors)}f", len(colors), *colors))
    assert part.colors is None if not colors else np.allclose(part.colors, RED, atol=1e-3)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"4OFF\n1 1 0\n", "'4OFF' is not OFF"),
        (b"nOFF\n4\n1 1 0\n", "'nOFF' is not OFF"),
        (b"OFF\n-1 1 0\n", "OFF header"),
        (
            b"OFF\n2147483647 1 0\n0 0 0 1 0 0\n",
            "2147483647 vertices and 1 faces, but only 1 lines follow, and other numbers",
        ),
        (
            b"OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 7\n",
            "OFF header: 3 vertices and 1 faces, but only 0 lines follow, and other numbers",
        ),
        (
            b"OFF 3 1 0 0 0 0 1 0 0 0 1 0 9 0 1 2\n",
            "OFF header: 3 vertices and 1 faces, but only 0 lines follow, and other numbers",
        ),
        (
            b"OFF 3 1 0 0 0 0 1 0 0 0 1 0 -1 0 1 2\n",
            "OFF header: 3 vertices and 1 faces, but only 0 lines follow, and other numbers",
        ),
        (b"OFF BINARY\n" + struct.pack(">3i", 2**31 - 1, 1, 0), "cut off or broken"),
        (b"OFF BINARY\n" + struct.pack(">3i4i", 0, 1, 0, 2**31 - 1, 0, 0, 0), "cut off or broken"),
        (b"OFF BINARY\n" + struct.pack(">3i4i", 0, 2**31 - 1, 0, -5, 0, 0, 0), "cut off or broken"),
        (
            ("OFF\n" + BODY.format("", "")).replace("3 0 1 2", "2147483648 0 1 2").encode(),
            "face 0: 2.14748e+09 corners",
        ),
        (("OFF\n" + BODY.format("", "")).replace("3 0 1 2", "3 0 1.5 2").encode(), "face 0: index out of range"),
        (("OFF\n" + BODY.format("", "")).replace("1 0 0", "1 0").encode(), "vertex 1: needs 3 numbers, not '1 0'"),
        (("OFF\n" + BODY.format("", "")).replace("1 0 0", "1 0,5 0").encode(), "with points for decimals"),
    ],
)
def test_what_is_broken_is_refused(content: bytes, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_off("a.off", content, Remarks())
    assert says in str(caught.value)


@pytest.mark.parametrize(
    "counts",
    [(3, 2**31 - 1, 3, 0), (2**31 - 1, 1, 3, 0), (3, 1, 2**31 - 1, 0), (3, 1, 3, 2**31 - 1), (3, 1, -1, 0),
     (3, 1, 3, -1), (-1, 1, 3, 0), (3, -1, 3, 0)],
)  # fmt: skip
def test_counts_of_binary_files_that_do_not_fit_are_refused_at_once(counts: tuple[int, int, int, int]) -> None:
    vertices, faces, corners, channels = counts
    points = struct.pack(">9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    face = struct.pack(">5i", corners, 0, 1, 2, channels)
    with pytest.raises(SceneError, match="the counts do not fit the file"):
        read(b"OFF BINARY\n" + struct.pack(">3i", vertices, faces, 0) + points + face)


def test_a_face_of_more_corners_than_its_line_has_is_refused() -> None:
    with pytest.raises(SceneError, match="has not as many"):
        read("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2147483648 0 1 2\n")
