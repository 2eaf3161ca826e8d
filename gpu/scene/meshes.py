"""PLY, STL and OFF files: bare meshes, matt grey or with vertex colours."""

import re
from pathlib import Path

from gpu.errors import SceneError
from gpu.scene.assemble import SceneParts, assemble
from gpu.scene.files import read_bytes
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.mtl import DEFAULT_MATERIAL
from gpu.scene.trimesh_parts import load_parts
from gpu.scene.types import Scene


def load_mesh(path: Path, limits: SceneLimits, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the PLY, STL or OFF file at `path`. Raises SceneError when it is broken or cut off."""
    content = read_bytes(path, limits)
    kind = path.suffix.lower().removeprefix(".")
    if kind == "off":
        _check_off(str(path), content)
    if kind == "stl" and content[:5] == b"solid" and content.count(b"endfacet") != content.count(b"facet normal"):
        raise SceneError(str(path), "", "a facet does not end; the file is cut off")
    header = content.partition(b"end_header")[0]
    shaded = kind == "ply" and re.search(rb"property\s+\w+\s+nx\s", header) is not None
    ignored = []
    if re.search(rb"comment\s+TextureFile", header):
        ignored.append("the texture of a PLY file is not supported and was ignored")
    parts = load_parts(str(path), content, kind, shaded)
    return assemble(str(path), SceneParts(parts, [DEFAULT_MATERIAL], ignored=ignored), limits, options)


def _check_off(source: str, content: bytes) -> None:
    """Raise SceneError when there are fewer lines than the header says; trimesh takes what there is."""
    lines = (line.partition(b"#")[0].strip() for line in content.splitlines())
    words = [line for line in lines if line]
    start = 1 if words and words[0].isalpha() else 0
    try:
        vertices, faces = (int(word) for word in words[start].removeprefix(b"OFF").split()[:2])
    except (IndexError, ValueError) as error:
        raise SceneError(source, "OFF header", "does not say how many vertices and faces follow") from error
    if min(vertices, faces) < 0 or len(words) - start - 1 < vertices + faces:
        found = len(words) - start - 1
        raise SceneError(source, "OFF header", f"{vertices} vertices and {faces} faces, but only {found} lines follow")
