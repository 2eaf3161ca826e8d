"""OBJ files, made canonical line by line before trimesh reads them.

trimesh 5 takes negative indices from the end of the file instead of from the line, skips what it cannot read and loses
emission. So each face becomes triangles with absolute, checked indices in the group of its material.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path

from gpu.errors import SceneError
from gpu.scene.assemble import MeshPart, SceneParts, assemble
from gpu.scene.files import read_bytes
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.mtl import DEFAULT_MATERIAL, MaterialLibrary
from gpu.scene.trimesh_parts import load_parts
from gpu.scene.types import Scene

_WIDTHS = {"v": 3, "vt": 1, "vn": 3}
_SILENT = {"o", "g", "s", "mg", "vp", "lod", "bevel", "c_interp", "d_interp"}


@dataclass
class _Canonical:
    """A file in canonical form. faces: lines by material name; rows: lines of v, vt and vn; count: how many of each."""

    source: str
    rows: list[str] = field(default_factory=list)
    count: dict[str, int] = field(default_factory=lambda: dict.fromkeys(_WIDTHS, 0))
    faces: dict[str, list[tuple[tuple[int, int, int], ...]]] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)
    ignored: dict[str, None] = field(default_factory=dict)


def load_obj(path: Path, limits: SceneLimits, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the OBJ file at `path`, with the materials of its MTL files (Ke is emission).

    Raises SceneError naming the line of what is broken, and for files outside the scene's folder.
    """
    text = read_bytes(path, limits).decode("utf-8", "replace")
    canonical = _read(str(path), text)
    library = MaterialLibrary(path, limits)
    for name in canonical.libraries:
        library.read(name)
    materials = [library.materials.get(name, DEFAULT_MATERIAL) for name in canonical.faces]
    for name in canonical.faces.keys() - library.materials.keys() - {""}:
        canonical.ignored[f"material {name} is not defined: its surfaces are grey"] = None
    parts: list[MeshPart] = []
    if canonical.faces:
        content = "\n".join(_lines(canonical)).encode()
        shaded = canonical.count["vn"] > 0
        # v = 0 is the bottom of an OBJ texture, the top of a glTF one.
        parts = load_parts(str(path), content, "obj", shaded, flip_v=True, split_groups=True, skip_materials=True)
    ignored = [*canonical.ignored, *library.ignored]
    return assemble(str(path), SceneParts(parts, materials, library.textures, ignored=ignored), limits, options)


def _read(source: str, text: str) -> _Canonical:
    canonical = _Canonical(source)
    material = ""
    lines = iter(enumerate(text.splitlines(), 1))
    for number, line in lines:
        while line.endswith("\\"):
            line = line[:-1] + next(lines, (0, ""))[1]
        key, _, value = line.strip().partition(" ")
        if key in _WIDTHS:
            canonical.rows.append(f"{key} {_numbers(source, number, key, value)}")
            canonical.count[key] += 1
        elif key == "f":
            canonical.faces.setdefault(material, []).append(_corners(canonical, number, value.split()))
        elif key == "usemtl":
            material = value.strip()
        elif key == "mtllib":
            canonical.libraries.append(value.strip())
        elif key in ("l", "p"):
            canonical.ignored["points and lines have no surface and were ignored"] = None
        elif key and not key.startswith("#") and key not in _SILENT:
            canonical.ignored[f"statement {key!r:.20} is not supported and was ignored"] = None
    return canonical


def _numbers(source: str, line: int, key: str, value: str) -> str:
    """The finite numbers of a v, vt or vn line: 3 of v (6 with a colour) and vn, 2 of vt."""
    words = value.split("#")[0].split()
    try:
        good = len(words) >= _WIDTHS[key] and all(isfinite(float(word)) for word in words)
    except ValueError:
        good = False
    if not good:
        raise SceneError(source, f"line {line}", f"{key} needs {_WIDTHS[key]} finite numbers, not {value!r:.60}")
    return " ".join([*words, "0"][:2] if key == "vt" else words[:3])


def _corners(canonical: _Canonical, line: int, words: list[str]) -> tuple[tuple[int, int, int], ...]:
    """Indices of v, vt and vn, from 1, of each corner of a face; 0 where a corner has none."""
    if len(words) < 3:
        raise SceneError(canonical.source, f"line {line}", "a face needs at least 3 corners")
    corners = []
    for word in words:
        found = [0, 0, 0]
        for place, (key, digits) in enumerate(zip(_WIDTHS, word.split("/"), strict=False)):
            if digits or key == "v":
                found[place] = _absolute(canonical, line, key, digits)
        corners.append((found[0], found[1], found[2]))
    return tuple(corners)


def _absolute(canonical: _Canonical, line: int, key: str, digits: str) -> int:
    """An index counted from 1; a negative one in the file counts back from the last `key` so far."""
    count = canonical.count[key]
    try:
        index = int(digits)
    except ValueError:
        index = 0
    index = index + count + 1 if index < 0 else index
    if not 1 <= index <= count:
        raise SceneError(canonical.source, f"line {line}", f"{key} index {digits!r:.20} does not exist, so far {count}")
    return index


def _lines(canonical: _Canonical) -> Iterator[str]:
    """The canonical file: a group a material, named by its number, of triangles that all have what any has."""
    yield from canonical.rows
    count = canonical.count
    if count["vt"]:
        yield "vt 0 0"
    if count["vn"]:
        yield "vn 0 0 0"  # no direction: becomes the geometric normal
    for number, faces in enumerate(canonical.faces.values()):
        yield f"g {number}"
        for face in faces:
            words = [
                f"{v}/{(vt or count['vt'] + 1) if count['vt'] else ''}/{(vn or count['vn'] + 1) if count['vn'] else ''}"
                for v, vt, vn in face
            ]
            words = [word.rstrip("/") for word in words]
            for corner in range(1, len(face) - 1):
                yield f"f {words[0]} {words[corner]} {words[corner + 1]}"
