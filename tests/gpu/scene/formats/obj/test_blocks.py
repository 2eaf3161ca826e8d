"""Blocks of OBJ files: all of the text in order, runs of one form together, what goes on in the next line whole."""

import numpy as np
import pytest

from gpu.scene.formats.obj.blocks import LEAST, blocks

FACES = "f 1/2/3 4/5/6\t-7/-8/-9 \nf 1/1/1 2/2/2 3/3/3 4/4/4\n"


def many(line: str, count: int = LEAST) -> str:
    return f"{line}\n" * count


@pytest.mark.parametrize(
    ("text", "forms"),
    [
        ("", []),
        ("# a\nv 1 2 3", [("", 1, 2)]),
        (many("v 1 2 3") + "g a\n" + many("f 1 2 3"), [("v", 1, LEAST), ("", LEAST + 1, 1), ("f", LEAST + 2, LEAST)]),
        (many("v 1 2 3", LEAST - 1), [("", 1, LEAST - 1)]),
        (many("v 1 2 3") + many("v 1 2 3 4 5 6"), [("v", 1, LEAST), ("v", LEAST + 1, LEAST)]),
        (many("v 1 nan 3") + many("vt 1 2"), [("", 1, LEAST), ("vt", LEAST + 1, LEAST)]),
        (many("f 1 2") + many("f 1//2 3//4 5//6"), [("", 1, LEAST), ("f", LEAST + 1, LEAST)]),
        ("f 1 \\\n2 \\\n" + many("v 1 2 3", LEAST + 1), [("", 1, 3), ("v", 4, LEAST)]),
    ],
)
def test_all_lines_are_in_a_block(text: str, forms: list[tuple[str, int, int]]) -> None:
    found = [*blocks(text)]
    assert "".join(block.text for block in found) == text
    assert [(block.key, block.place, block.count) for block in found] == forms


def test_lines_of_no_known_form_have_their_numbers() -> None:
    (block,) = blocks("g a\nf 1 \\\n2 3\no b")
    assert [*block.lines()] == [(1, "g a"), (2, "f 1  2 3"), (4, "o b")]


def test_numbers_and_corners_of_a_block() -> None:
    (rows,) = blocks(many("vt 1.5 -2e3"))
    assert np.array_equal(rows.rows(), [[1.5, -2000.0]] * LEAST)
    (broken,) = blocks(many("v 1.5 2 3.4.5"))
    assert broken.rows() is None
    (faces,) = blocks(FACES * LEAST)
    corners, counts = faces.corners()
    assert faces.columns == (0, 1, 2)
    assert counts.tolist() == [3, 4] * LEAST
    assert corners[:7].tolist() == [
        [1, 2, 3], [4, 5, 6], [-7, -8, -9], [1, 1, 1], [2, 2, 2], [3, 3, 3], [4, 4, 4],
    ]  # fmt: skip
