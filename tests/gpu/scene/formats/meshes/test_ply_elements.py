"""What PLY files hold: types, orders of bytes, lists of any length, broken headers."""

import struct

import pytest

from gpu.errors import SceneError
from gpu.scene.formats.meshes.ply_elements import PlyFile, read_elements
from gpu.scene.remarks import Remarks

HEADER = """ply
format {} 1.0
comment Größe
obj_info made by hand
element thing 2
property short a
property list uchar int b
property double c
end_header
"""
ROWS = [(-1, (5, 6, 7), 0.5), (2, (8,), 1.5)]


def content(kind: str, ends: str = "\n", encoding: str = "utf-8") -> bytes:
    head = HEADER.format(kind).replace("\n", ends).encode(encoding)
    if kind == "ascii":
        return head + ends.join(f"{a} {len(b)} {' '.join(map(str, b))}\t{c}" for a, b, c in ROWS).encode()
    order = ">" if "big" in kind else "<"
    return head + b"".join(struct.pack(f"{order}hB{len(b)}id", a, len(b), *b, c) for a, b, c in ROWS)


def read(data: bytes) -> tuple[PlyFile, tuple[str, ...]]:
    remarks = Remarks()
    return read_elements("a.ply", data, remarks), remarks.sentences()


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_rows_of_lists_that_differ_in_length(kind: str, ends: str) -> None:
    file, says = read(content(kind, ends, "cp1252"))
    thing = file.elements["thing"]
    assert {name: column.tolist() for name, column in thing.columns.items()} == {"a": [-1, 2], "c": [0.5, 1.5]}
    assert (thing.lists["b"].values.tolist(), thing.lists["b"].counts.tolist()) == ([5, 6, 7, 8], [3, 1])
    assert file.comments == ["Größe", "made by hand"]
    assert says == ()


def test_bytes_after_the_end_are_said() -> None:
    assert read(content("binary_little_endian") + b"\n")[1] == ("bytes after the last element were ignored (1)",)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_files_that_are_cut_off_are_refused(kind: str) -> None:
    with pytest.raises(SceneError, match=r"element thing: the file ends before its 2 rows do"):
        read(content(kind)[:-4])


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("ply\n", "pl\n", "not a PLY file"),
        ("end_header", "end", "not a PLY file"),
        ("ascii", "text", "header line 2: 'format text 1.0' cannot be read"),
        ("short", "number", "header line 6"),
        ("thing 2", "thing -2", "header line 5"),
        ("thing 2", "thing 1.5", "header line 5"),
        ("double c", "double a", "header line 8"),
        ("format", "comment", "no format is named"),
        ("\t0.5", "\t0,5", "with points for decimals"),
        ("3 5", "-3 5", "cut off"),
        ("3 5", "3e12 5", "cut off"),
        ("\t1.5", "\t1.5 9", "1 numbers more than the header says"),
    ],
)
def test_what_is_broken_is_refused(old: str, new: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(content("ascii").replace(old.encode(), new.encode(), 1))
    assert says in str(caught.value)
