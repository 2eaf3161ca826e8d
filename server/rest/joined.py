"""The page's modules and style sheets, each joined with all that it imports: a page comes in a few answers. One a file
would take seconds on a line with a long way.

An address has the files' digest in it, so that browsers keep what is there for good. In a joined module each other one
is a function's scope, in the order in which they run; its source map, which only a debugger asks for, leads line by
line to the files themselves.
"""

import gzip
import hashlib
import json
import posixpath
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

PLACE = "joined"  # the folder of what is joined, beside the files: PLACE/DIGEST/FILE
LEVEL = 9  # of compression, once for all visits
SUFFIXES = (".css", ".html", ".js")

_IMPORT = re.compile(r'^import (\{[^}]*\}) from "([^"]+)";', re.MULTILINE)
_IMPORTED = re.compile(r"(\w+) as (\w+)")
_EXPORT = re.compile(r"^export (?=(?:async )?(?:class|const|function) (\w+))", re.MULTILINE)
_OTHER = re.compile(r"^(?:import\b(?!\()|export (?!(?:async )?(?:class|const|function) \w)).*", re.MULTILINE)
_SHEET = re.compile(r'^@import "([^"]+)";\n', re.MULTILINE)
_LINK = re.compile(r'( (?:href|src)=")([^":]+\.(?:css|js)")')
_DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"


@dataclass(frozen=True)
class Text:
    """What is sent. packed: the same, by gzip."""

    plain: bytes
    packed: bytes


class Joined:
    """What is joined of the files of a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stamps: list[tuple[str, int, int]] = []
        self._files: dict[str, str] = {}
        self.digest = ""
        self._kept = lru_cache(self._make)
        self.look()

    def look(self) -> None:
        """Read the files again when one has changed."""
        found = [path for path in sorted(self._folder.rglob("*")) if path.suffix in SUFFIXES]
        stamps = [(str(path), (it := path.stat()).st_mtime_ns, it.st_size) for path in found]
        if stamps == self._stamps:
            return
        self._files = {path.relative_to(self._folder).as_posix(): path.read_text(encoding="utf-8") for path in found}
        self._stamps = stamps
        self.digest = hashlib.sha256(json.dumps(self._files).encode()).hexdigest()[:20]
        self._kept.cache_clear()

    def text(self, name: str) -> Text | None:
        """A file with all that it imports, or a module's source map (FILE.map); None where there is none.

        A page has the addresses of what is joined. Raises ValueError where a module imports or exports in another way
        than by names, `import { a, b as c } from "./file.js";`, or imports itself by others.
        """
        known = name in self._files or (name.endswith(".js.map") and name.removesuffix(".map") in self._files)
        return self._kept(name) if known else None

    def _make(self, name: str) -> Text:
        if name.endswith(".html"):
            text = _LINK.sub(rf"\1{PLACE}/{self.digest}/\2", self._files[name])
        elif name.endswith(".css"):
            text = self._sheet(name)
        elif name.endswith(".js"):
            text = self._module(name)
        else:
            text = self._map(name.removesuffix(".map"))
        plain = text.encode()
        return Text(plain, gzip.compress(plain, LEVEL, mtime=0))

    def _sheet(self, name: str) -> str:
        return _SHEET.sub(lambda found: self._sheet(_beside(name, found[1])), self._files[name])

    def _module(self, name: str) -> str:
        *others, _ = self._order(name)
        parts = [_in_scope(other, _body(other, self._files[other], name)) for other in others]
        return "".join([*parts, _body(name, self._files[name], name), f"//# sourceMappingURL={Path(name).name}.map\n"])

    def _map(self, name: str) -> str:
        """A map (https://tc39.es/ecma426/) of whole lines."""
        order = self._order(name)
        mappings, source, line = list[str](), 0, 0
        for number, file in enumerate(order):
            lines = list[str]()
            for at in range(self._files[file].count("\n")):
                lines.append("A" + _digits(number - source) + _digits(at - line) + "A")
                source, line = number, at
            mappings += lines if file == name else ["", *lines, ""]  # in a scope
        up = "../" * (name.count("/") + 2)
        sources = [up + file for file in order]
        return json.dumps({"version": 3, "sources": sources, "names": [], "mappings": ";".join(mappings)})

    def _order(self, name: str) -> list[str]:
        """A module and all that it imports, each after what it imports itself."""
        order, under_way = list[str](), set[str]()

        def visit(file: str) -> None:
            if file in order:
                return
            if file in under_way:
                raise ValueError(f"{file} imports itself by way of others")
            under_way.add(file)
            for _, other in _IMPORT.findall(self._files[file]):
                visit(_beside(file, other))
            order.append(file)

        visit(name)
        return order


def _in_scope(name: str, body: str) -> str:
    """A module as an object of what it exports; its lines stay whole, between one before and one after them."""
    exported = ", ".join(_EXPORT.findall(body))
    return f"const {_variable(name)} = (() => {{\n{_EXPORT.sub('', body)}return {{ {exported} }}; }})();\n"


def _body(name: str, text: str, entry: str) -> str:
    """A module with variables for imports, line for line, in what is joined for `entry` and has that one's place."""

    def imported(found: re.Match[str]) -> str:
        names = _IMPORTED.sub(r"\1: \2", found[1])
        return f"const {names} = {_variable(_beside(name, found[2]))};"

    body = _IMPORT.sub(imported, text)
    if other := _OTHER.search(body):
        raise ValueError(f"{name}: cannot be joined: {other[0]}")
    if name == entry:
        return body
    place = "../" * entry.count("/") + name
    return body.replace("import.meta.url", f'new URL("{place}", import.meta.url)')


def _variable(name: str) -> str:
    return "$" + re.sub(r"\W", "_", name.removesuffix(".js"))


def _beside(name: str, other: str) -> str:
    """The file that another one names."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(name), other))


def _digits(number: int) -> str:
    """A signed number in the digits of source maps: five bits each, the lowest first, the sign the lowest of all."""
    rest, text = (abs(number) << 1) | (number < 0), ""
    while True:
        rest, digit = rest >> 5, rest & 31
        text += _DIGITS[digit | (32 if rest else 0)]
        if not rest:
            return text
