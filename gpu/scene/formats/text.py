"""Text of scene files: any encoding, any ends of lines, numbers as programs write them."""

import codecs
import re
from collections.abc import Iterable, Iterator

import numpy as np

from gpu.scene.types import Doubles

_MARKS = {  # UTF-32's little-endian mark begins with that of UTF-16
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
# How Microsoft's C library writes what is no number: 1.#QNAN, -1.#IND, 1.#INF, -nan(ind).
_NO_NUMBER = re.compile(r"[-+]?(?:\d\.#(?:QNAN|SNAN|IND|INF)\d*|nan\((?:ind|snan|\w*)\))", re.IGNORECASE)
_COMMENT = re.compile(r"(?:^|\s)#.*")


def decoded(content: bytes) -> str:
    """`content` by its byte order mark, else as UTF-8, else as Windows-1252; all lines end in a line feed."""
    for mark, encoding in _MARKS.items():
        if content.startswith(mark):
            text = content[len(mark) :].decode(encoding, "replace")
            break
    else:
        try:
            text = content.decode()
        except UnicodeDecodeError:
            text = content.decode("cp1252", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def without_mark(content: bytes) -> bytes:
    """`content` without a byte order mark, as UTF-8 where it has one."""
    return decoded(content).encode() if content.startswith(tuple(_MARKS)) else content


def logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers from 1; one that ends in a backslash goes on in the next."""
    lines = iter(enumerate(text.split("\n"), 1))
    if "\\" not in text:
        yield from lines
    for number, line in lines:
        joined = line.rstrip()
        while joined.endswith("\\"):
            joined = f"{joined[:-1]} {next(lines, (0, ''))[1]}".rstrip()
        yield number, joined


def uncommented(line: str) -> str:
    """`line` up to a # that white space or nothing stands before."""
    return _COMMENT.sub("", line, count=1) if "#" in line else line


def number(word: str) -> float:
    """The number that `word` is; NaN for a program's way to write none. Raises ValueError for anything else."""
    if "_" in word:
        raise ValueError(f"{word!r} is not a number")
    try:
        return float(word)
    except ValueError:
        if _NO_NUMBER.fullmatch(word):
            return float("nan")
        raise


def numbers(words: Iterable[str]) -> Doubles:
    """The numbers (number,) that `words` are. Raises ValueError where one is none."""
    return np.fromiter(map(number, words), np.float64)
