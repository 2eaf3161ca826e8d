"""Text of scene files: encodings, ends of lines, comments, and numbers as programs write them."""

from math import inf, isnan

import numpy as np
import pytest

from gpu.scene.formats.text import decoded, logical_lines, number, numbers, uncommented, without_mark


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252"])
def test_any_encoding_is_read(encoding: str) -> None:
    assert decoded("usemtl wänd\nv 1\n".encode(encoding)) == "usemtl wänd\nv 1\n"


def test_marks_of_both_byte_orders_are_no_content() -> None:
    for mark, encoding in ((b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be")):
        assert decoded(mark + "OFF".encode(encoding)) == "OFF"
        assert without_mark(mark + "OFF".encode(encoding)) == b"OFF"
    assert without_mark(b"\xef\xbb\xbfOFF") == b"OFF"
    assert without_mark(b"\x93\xff") == b"\x93\xff"


def test_lines_end_as_on_any_system_and_go_on_after_a_backslash() -> None:
    lines = list(logical_lines(decoded(b"a\r\nb\\\r\n c\rd \\ \ne\fg\n")))
    assert lines == [(1, "a"), (2, "b  c"), (4, "d  e\x0cg"), (6, "")]


def test_comments_begin_a_word() -> None:
    assert uncommented("Kd 1 0 0 # red") == "Kd 1 0 0"
    assert uncommented("# all") == ""
    assert uncommented("map_Kd wall#2.png") == "map_Kd wall#2.png"


@pytest.mark.parametrize("word", ["nan", "-1.#IND", "1.#QNAN00", "-nan(ind)", "1.#INF"])
def test_what_programs_write_for_no_number_is_none(word: str) -> None:
    assert isnan(number(word))
    assert np.isnan(numbers(["1", word, "2"])).tolist() == [False, True, False]


def test_numbers() -> None:
    assert (number("1e3"), number("-inf")) == (1000.0, -inf)
    assert numbers(["1", "2.5", "-3e1"]).tolist() == [1.0, 2.5, -30.0]


@pytest.mark.parametrize("word", ["x", "1,5", "1_000", "0x10", "1.2.3"])
def test_words_are_no_numbers(word: str) -> None:
    with pytest.raises(ValueError, match=r"number|convert"):
        number(word)
    with pytest.raises(ValueError, match=r"number|convert"):
        numbers(["1", word])
