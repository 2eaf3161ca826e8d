"""Geometries of COLLADA, a part for each material, placed by what instantiates them."""

from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.collada.materials import Binding, Materials, bindings_of
from gpu.scene.formats.collada.nodes import Instance
from gpu.scene.formats.collada.primitives import Corners, Primitives
from gpu.scene.formats.outlines import covered, usable_positions
from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import placed
from gpu.scene.types import Doubles
from gpu.scene.validate import check_count, check_indices


@dataclass
class _Use:
    """A geometry with what its materials are, and where and as what it is used."""

    geometry: Element
    bindings: dict[str, Binding]
    matrices: list[Doubles] = field(default_factory=list)
    names: list[str] = field(default_factory=list)


class Meshes:
    """The geometries that instances use."""

    def __init__(self, document: Document, materials: Materials) -> None:
        self._document, self._materials = document, materials
        self._uses: dict[tuple[object, ...], _Use] = {}

    def add(self, instance: Instance) -> None:
        """Note that `instance` uses a geometry, or a controller of one, which is shown in its bind pose."""
        matrix, url, tag = instance.to_world, instance.url, instance.kind.removeprefix("instance_")
        for _ in range(8):  # a skin of a morph of a geometry
            found = self._document.find(url, tag)
            if found is None:
                return
            if tag == "geometry":
                bindings = bindings_of(self._document, instance.element)
                key = (found, *sorted(bindings.items()))
                use = self._uses.setdefault(key, _Use(found, bindings))
                use.matrices.append(matrix)
                use.names.append(instance.node)
                return
            self._document.remarks.add("skinned and morphed meshes are shown as they are without", instance.node)
            skin = found.find("skin")
            shape = None if skin is None else skin.find("bind_shape_matrix")
            if shape is not None:
                bind = self._document.numbers(shape, f"{instance.node}: bind_shape_matrix", 16)
                matrix = matrix @ bind.reshape(4, 4)
            deformer = skin if skin is not None else found.find("morph")
            url = None if deformer is None else deformer.get("source")
            target = next((it for it in self._document.root.iter() if it.get("id") == (url or "")[1:]), None)
            tag = "controller" if target is not None and target.tag == "controller" else "geometry"

    def parts(self) -> list[MeshPart]:
        """All that was added, placed. Raises SceneError when a geometry is broken or there are too many triangles."""
        limits, source = self._document.limits, str(self._document.path)
        primitives = Primitives(self._document)
        found, triangles = [], 0
        for use in self._uses.values():
            for corners in primitives.of(use.geometry):
                part = self._part(corners, use.bindings)
                triangles += len(part.triangles) * len(use.matrices)
                check_count(source, "triangles", triangles, limits.max_triangles, "max_triangles")
                found.append(placed(part, np.stack(use.matrices), use.names))
        return found

    def _part(self, corners: Corners, bindings: dict[str, Binding]) -> MeshPart:
        source, remarks = str(self._document.path), self._document.remarks
        check_indices(source, f"{corners.place}: vertices", corners.vertices, len(corners.positions))
        positions = usable_positions(
            source, corners.positions, corners.vertices, remarks, lambda row: f"{corners.place}: vertex {row}"
        )
        cut = covered(positions, corners.vertices, corners.counts, remarks)
        used, triangles = np.unique(cut.triangles, return_inverse=True)
        binding = bindings.get(corners.material)
        number, uv_sets = self._materials.number(binding, corners.material)
        uvs = [corners.uvs.get(uv_set, next(iter(corners.uvs.values()), None)) for uv_set in uv_sets]
        empty = np.zeros((len(used), 2))
        return MeshPart(
            positions=positions[corners.vertices[used]],
            triangles=triangles.reshape(-1, 3),
            normals=None if corners.normals is None else corners.normals[used],
            # v = 0 is the bottom of a COLLADA texture, the top of a glTF one.
            uvs=tuple(empty if uv is None else uv[used] * (1.0, -1.0) + (0.0, 1.0) for uv in uvs),
            colors=None if corners.colors is None else corners.colors[used],
            material=number,
            name=corners.place,
        )
