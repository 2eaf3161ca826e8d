"""The text of OBJ files in blocks: runs of lines as most programs write them, which are read at once, and other lines.

A million faces one by one take longer than a service waits for a file.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gpu.scene.formats.text import logical_lines
from gpu.scene.types import Doubles, Integers

LEAST = 12
"""Lines of a block: fewer are sooner read one by one."""
_MOST = 1 << 16  # so that what is made of one stays small
_WHITE, _NUMBER, _INDEX = r"[ \t]++", r"[-+.0-9eE]++", r"-?+[0-9]{1,9}+"
_CORNERS = {
    (0, 1, 2): f"{_INDEX}/{_INDEX}/{_INDEX}",
    (0, 1): f"{_INDEX}/{_INDEX}",
    (0, 2): f"{_INDEX}//{_INDEX}",
    (0,): _INDEX,
}
_ROWS = (("v", 3), ("v", 6), ("vt", 2), ("vt", 3), ("vn", 3))


def _run(key: str, word: str, count: str) -> re.Pattern[str]:
    """Lines of `key` and `count` such words."""
    return re.compile(rf"(?:{key}(?:{_WHITE}{word}){{{count}}}+[ \t]*+\n){{1,{_MOST}}}+")


_FORMS = [
    *(("f", 0, columns, _run("f", corner, "3,")) for columns, corner in _CORNERS.items()),
    *((key, width, (), _run(key, _NUMBER, str(width))) for key, width in _ROWS),
]
_OTHERS = re.compile(r"(?:[^fv\n\\][^\n\\]*+\n)++")  # lines that are neither of these nor go on in the next


@dataclass(frozen=True)
class Block:
    """Lines of one form. place: the number of the first line, from 1; count: how many there are; text: theirs; key: v,
    vt, vn or f, "" where they have no form that is known.

    width: how many numbers a v, vt or vn has; columns: which of v, vt and vn the corners of an f name.
    """

    place: int
    count: int
    text: str
    key: str = ""
    width: int = 0
    columns: tuple[int, ...] = ()

    def lines(self) -> Iterator[tuple[int, str]]:
        """The lines with their numbers; one that ends in a backslash goes on in the next."""
        return ((self.place - 1 + number, line) for number, line in logical_lines(self.text))

    def rows(self) -> Doubles | None:
        """The numbers (line, width) of a v, vt or vn; None where a word is none."""
        try:
            words = map(float, self.text.replace(self.key, " ").split())
            return np.fromiter(words, np.float64, self.count * self.width).reshape(self.count, self.width)
        except ValueError:
            return None

    def corners(self) -> tuple[Integers, Integers]:
        """Of faces the indices (corner, columns), as they are written, and how many corners each line has (line,)."""
        letters = np.frombuffer(self.text.encode(), np.uint8)
        begins = (letters[1:] > ord(" ")) & (letters[:-1] <= ord(" "))  # a word that is no key
        ends = np.cumsum(begins)[np.flatnonzero(letters == ord("\n")) - 1]
        counts = np.diff(ends, prepend=0)
        counts[1:] -= 1  # the key of every line but the first is a word
        words = self.text.replace("f", " ").replace("/", " ")
        indices = np.fromstring(words, np.int64, sep=" ")
        return indices.reshape(-1, len(self.columns)), counts


def blocks(text: str) -> Iterator[Block]:
    """All of `text` in blocks, in order."""
    at = begin = 0
    place = first = 1  # the numbers of the lines there
    forms = {letter: [form for form in _FORMS if form[0][0] == letter] for letter in "fv"}
    while at < len(text):
        found = _known_form(text, at, place, forms.get(text[at], []))
        known = found is not None and found.count >= LEAST
        if at > begin and (known or place - first >= _MOST):
            yield Block(first, place - first, text[begin:at])
            begin, first = at, place
        if found is None:
            others = _OTHERS.match(text, at)
            end = others.end() if others else _line_end(text, at)
            at, place = end, place + max(text.count("\n", at, end), 1)
            continue
        at, place = at + len(found.text), place + found.count
        if known:
            yield found
            begin, first = at, place
    if at > begin:
        yield Block(first, place - first, text[begin:])


def _known_form(
    text: str, at: int, place: int, forms: list[tuple[str, int, tuple[int, ...], re.Pattern[str]]]
) -> Block | None:
    """The lines from `at` on that all have the first of `forms` that fits, which then comes first; None without one."""
    for index, (key, width, columns, pattern) in enumerate(forms):
        if match := pattern.match(text, at):
            forms.insert(0, forms.pop(index))
            return Block(place, match[0].count("\n"), match[0], key, width, columns)
    return None


def _line_end(text: str, at: int) -> int:
    """Where the line at `at` ends, with those that it goes on in."""
    end = text.find("\n", at) + 1 or len(text)
    while end < len(text) and text[at:end].rstrip().endswith("\\"):
        at, end = end, text.find("\n", end) + 1 or len(text)
    return end
