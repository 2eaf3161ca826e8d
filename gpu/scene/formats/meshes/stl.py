"""STL files, binary and ASCII, as programs write them."""

import re

import numpy as np

from gpu.errors import SceneError
from gpu.scene.floats import doubles
from gpu.scene.formats.outlines import covered, usable_positions
from gpu.scene.formats.text import decoded, numbers, without_mark
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
# A name goes to the end of its line, or to the first facet where all is on one line.
_NAME = re.compile(r"[^\n]*?(?=\bfacet\s+normal\s+[-+.\d]|\n|\Z)")
_COMMENT = re.compile(r"^\s*(?:#|;|//)[^\n]*", re.MULTILINE)
_KEYWORDS = {"facet", "vertex", "endfacet"}
_TRIANGLE = ["facet", "vertex", "vertex", "vertex", "endfacet"]
_POINT = r"(?:\s++[-+]?+(?:\d++\.?+\d*+|\.\d++)(?:e[-+]?+\d++)?+){3}+"
_CORNERS = rf"outer\s++loop(?:\s++vertex{_POINT}){{3}}+\s++endloop"
_USUAL = re.compile(rf"(?:\s*+facet\s++normal{_POINT}\s++{_CORNERS}\s++endfacet)*+\s*+", re.ASCII)
_WORDS = ("endfacet", "facet", "normal", "outer", "endloop", "loop", "vertex")  # of such facets, the longer before


def read_stl(source: str, content: bytes, remarks: Remarks) -> MeshPart:
    """The triangles of an STL file; the order of their corners says which side is the front.

    Raises SceneError when it is cut off or neither binary nor ASCII.
    """
    content = without_mark(content)
    found = int.from_bytes(content[80:_HEADER], "little") if len(content) >= _HEADER else -1
    exact = len(content) == _HEADER + found * _FACET.itemsize
    if not exact and re.match(rb"\s*solid\b", content, re.IGNORECASE) and re.search(rb"(?i)\bvertex\s", content):
        return _ascii(source, decoded(content), remarks)
    if len(content) < _HEADER:
        raise SceneError(source, "", "not an STL file: neither text with facets nor long enough to be binary")
    return _binary(source, content, found, remarks)


def _binary(source: str, content: bytes, said: int, remarks: Remarks) -> MeshPart:
    """The facets of a binary file, of which its header says there are `said`."""
    whole, rest = divmod(len(content) - _HEADER, _FACET.itemsize)
    if said > whole and rest:
        raise SceneError(source, "", f"{said:,} facets, but only {whole:,} follow; the file is cut off")
    if said == 0 or said > whole:
        remarks.add(f"the header says {said:,} facets: all {whole:,} that follow were taken")
        said = whole
    beyond = len(content) - _HEADER - said * _FACET.itemsize
    remarks.add_count("bytes after the last facet were ignored", beyond)
    facets = np.frombuffer(content, _FACET, said, _HEADER)
    remarks.add_count(
        "facets have an attribute, a colour of some programs, that was ignored",
        int(facets["attribute"].astype(bool).sum()),
    )
    if b"COLOR=" in content[:80]:
        remarks.add("the colour in the header was ignored")
    corners = doubles(facets["corners"].reshape(-1, 3))
    return _part(source, corners, np.full(said, 3), doubles(facets["normal"]), remarks)


def _ascii(source: str, text: str, remarks: Remarks) -> MeshPart:
    """The facets of a file of text."""
    first, *named = (piece.rstrip(" \t").removesuffix("end") for piece in text.lower().split("solid"))
    text = "\n".join([first, *(_NAME.sub("", piece, count=1) for piece in named)])
    if any(mark in text for mark in "#;/"):
        text = _COMMENT.sub("", text)
    if _USUAL.fullmatch(text):
        facets = _usual_facets(text)
        return _part(source, facets[:, 1:].reshape(-1, 3), np.full(len(facets), 3), facets[:, 0], remarks)
    words = text.split()
    if "end" in words:
        words = re.sub(r"\bend\s+(?=facet|loop)", "end", text).split()
    places = [place for place, word in enumerate(words) if word in _KEYWORDS]
    keywords = [words[place] for place in places]
    count = len(keywords) // len(_TRIANGLE)
    counts = np.full(count, 3) if keywords == _TRIANGLE * count else _corner_counts(source, keywords)
    corners = _triples(source, words, [place for place in places if words[place] == "vertex"])
    normals = _triples(source, words, [place + 1 for place in places if words[place] == "facet"])
    return _part(source, corners, counts, normals, remarks)


def _usual_facets(text: str) -> Doubles:
    """The normal and the corners (facet, 4, 3) of facets of three corners that are written as most programs do."""
    for word in _WORDS:
        text = text.replace(word, " ")
    return np.fromstring(text, sep=" ").reshape(-1, 4, 3)


def _corner_counts(source: str, keywords: list[str]) -> Integers:
    """How many corners each facet has, where not all have three."""
    counts: list[int] = []
    is_open = False
    for keyword in keywords:
        if (keyword == "facet") == is_open:
            break
        if keyword == "vertex":
            counts[-1] += 1
        elif keyword == "facet":
            counts.append(0)
        is_open = keyword != "endfacet"
    else:
        if not is_open:
            return np.array(counts, np.int64)
    raise SceneError(source, f"facet {len(counts)}", "a facet does not end; the file is cut off")


def _triples(source: str, words: list[str], places: list[int]) -> Doubles:
    """The 3 numbers (place, 3) that follow each of these places in `words`."""
    try:
        values = numbers(words[place + after] for place in places for after in (1, 2, 3))
    except (ValueError, IndexError) as error:
        problem = f"a vertex or a normal is not 3 numbers with points for decimals: {error}"
        raise SceneError(source, "", problem) from error
    return values.reshape(-1, 3)


def _part(source: str, corners: Doubles, counts: Integers, normals: Doubles, remarks: Remarks) -> MeshPart:
    """The facets whose corners (corner, 3) follow one another; normals: (facet, 3) as the file has them."""
    order = np.arange(len(corners))
    positions = usable_positions(source, corners, order, remarks, lambda corner: f"facet {corner // 3}")
    cut = covered(positions, order, counts, remarks)
    sides = np.einsum("tc,tc->t", area_vectors(positions, cut.triangles), np.nan_to_num(normals)[cut.polygons])
    remarks.add_count("facets have a normal against the order of their corners, which counts", int((sides < 0.0).sum()))
    return MeshPart(positions, cut.triangles, name="facets")
