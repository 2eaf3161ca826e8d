"""PLY files: faces and triangle strips, with normals and colours of vertices, or colours of faces."""

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.mesh_colors import linear_colors
from gpu.scene.formats.meshes.ply_elements import Element, Lists, read_elements
from gpu.scene.formats.outlines import FaceMesh, face_part, whole
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers

_INDICES = ("vertex_indices", "vertex_index")
# What programs call the channels of a colour.
_COLORS = (
    ("red", "green", "blue", "alpha"),
    ("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"),
    ("r", "g", "b", "a"),
)
# What is white in a colour of each type; floating point has 0–1, or 0–255.
_WHITE = {"b": 127.0, "B": 255.0, "h": 32767.0, "H": 65535.0, "i": 255.0, "I": 255.0, "q": 255.0, "Q": 255.0}


def read_ply(source: str, content: bytes, remarks: Remarks) -> MeshPart:
    """The faces and triangle strips of a PLY file. Raises SceneError when it is broken or cut off."""
    file = read_elements(source, content, remarks)
    nothing = Element("", 0)
    vertex, face, strip = (file.elements.get(name, nothing) for name in ("vertex", "face", "tristrips"))
    for name, element in file.elements.items():
        if name not in ("vertex", "face", "tristrips"):
            remarks.add(f"element {name} ({element.rows:,}) is not shown and was ignored")
    if any(comment.lower().startswith("texturefile") for comment in file.comments):
        remarks.add("the texture of a PLY file is not supported and was ignored")
    positions = _table(vertex, ("x", "y", "z"))
    if positions is None:
        raise SceneError(source, "element vertex", "x, y and z are not all there")
    used = {"x", "y", "z", *_INDICES}
    normals = _table(vertex, ("nx", "ny", "nz"))
    used |= {"nx", "ny", "nz"} if normals is not None else set()
    colors, names = _colors(vertex, remarks)
    face_colors, face_names = _colors(face, remarks)
    for element, known in ((vertex, used | names), (face, used | face_names), (strip, used)):
        unused = [each.name for each in element.properties if each.name not in known]
        if unused and element.rows:
            remarks.add(f"of element {element.name}, not used: {', '.join(unused)}"[:200])
    faces, strips = _indices(face), _strip_triangles(_indices(strip))
    if face_colors is not None and len(strips):
        face_colors = np.concatenate([face_colors, np.ones((len(strips), 4))])
    mesh = FaceMesh(
        positions,
        np.concatenate([whole(faces.values), strips.reshape(-1)]),
        np.concatenate([faces.counts, np.full(len(strips), 3)]),
        normals,
        colors,
        face_colors,
    )
    return face_part(source, mesh, remarks)


def _table(element: Element, names: tuple[str, ...]) -> Doubles | None:
    """The columns called `names`, (row, name), None where one is not there."""
    if not all(name in element.columns for name in names):
        return None
    return np.stack([element.columns[name] for name in names], axis=1)


def _colors(element: Element, remarks: Remarks) -> tuple[Doubles | None, set[str]]:
    """Linear colours (row, 4) of an element where it has any, and the names of their properties."""
    for names in _COLORS:
        found = next((table for some in (names, names[:3]) if (table := _table(element, some)) is not None), None)
        if found is not None:
            return linear_colors(found, remarks, _WHITE.get(element.code(names[0]))), set(names[: found.shape[1]])
    return None, set()


def _indices(element: Element) -> Lists:
    """The lists of vertices of an element, empty where it has none."""
    found = next((element.lists[name] for name in _INDICES if name in element.lists), None)
    return found or Lists(np.empty(0), np.empty(0, np.int64))


def _strip_triangles(strips: Lists) -> Integers:
    """The triangles (triangle, 3) of strips, in which -1 ends a strip and every other triangle is turned around."""
    ends = np.cumsum(strips.counts)
    corners = np.insert(whole(strips.values), ends, -1)
    if len(corners) < 3:
        return np.empty((0, 3), np.int64)
    first = np.arange(len(corners))
    since = first - np.maximum.accumulate(np.where(corners < 0, first + 1, 0))
    triples = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    turned = np.where((since[:-2] % 2 == 1)[:, None], triples[:, [1, 0, 2]], triples)
    return turned[(triples >= 0).all(axis=1)]
