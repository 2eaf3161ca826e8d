"""Triangles of IFC products, as IfcOpenShell's iterator makes them: openings cut, a part an element and style."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gpu.errors import SceneError, brief
from gpu.scene.formats.ifc.styles import Styles
from gpu.scene.limits import SceneLimits
from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import placed
from gpu.scene.validate import check_count

_NAMED = 3
_MOST_NAME = 30  # of a product's name within the id of its object, which has 80 characters


@dataclass
class Geometry:
    """Reads bodies in the file's unit of length. Once `parts` is done, sentences: what was left out; notes: added."""

    source: str
    geom: Any
    model: Any
    limits: SceneLimits
    styles: Styles = field(init=False)
    metres_per_unit: float = 1.0
    sentences: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.styles = Styles(self.model)

    def parts(self, products: Sequence[Any]) -> list[MeshPart]:
        """The mesh parts of `products`. Raises SceneError when limits are exceeded or nothing can be converted."""
        parts: list[MeshPart] = []
        converted, unstyled, triangles, vertices = set[str](), set[str](), 0, 0
        for element in self._elements(products):
            if any(style.instance_id() <= 0 for style in element.geometry.materials):
                unstyled.add(element.guid)
            for part in self._element_parts(element):
                converted.add(element.guid)
                triangles, vertices = triangles + len(part.triangles), vertices + len(part.positions)
                parts.append(part)
            check_count(self.source, "triangles", triangles, self.limits.max_triangles, "max_triangles")
            check_count(self.source, "vertices", vertices, self.limits.max_vertices, "max_vertices")
        broken = [product.GlobalId for product in products if product.GlobalId not in converted]
        if broken:
            named = ", ".join(map(str, broken[:_NAMED])) + (", …" if len(broken) > _NAMED else "")
            self.sentences.append(f"elements whose geometry cannot be converted, left out: {len(broken)} ({named})")
        if unstyled:
            self.notes.append(f"elements without a style, which have a colour by their type: {len(unstyled)}")
        return parts

    def _elements(self, products: Sequence[Any]) -> Iterator[Any]:
        """Shapes in the order of the file: more than one thread would mix it, and count twice against limits."""
        if not products:
            return
        settings = self.geom.settings()
        settings.set("weld-vertices", False)  # so that vertices have the normals of the surface that they are on
        try:
            iterator = self.geom.iterator(settings, self.model, 1, include=list(products))
            more = iterator.initialize()
            self.metres_per_unit = float(iterator.unit_magnitude())
            while more:
                yield iterator.get()
                more = iterator.next()
        except RuntimeError as error:
            raise SceneError(self.source, "", f"its geometry cannot be converted: {error}") from error

    def _element_parts(self, element: Any) -> Iterator[MeshPart]:
        mesh = element.geometry
        positions = np.frombuffer(mesh.verts_buffer, np.float64).reshape(-1, 3)
        normals = np.frombuffer(mesh.normals_buffer, np.float64).reshape(-1, 3)
        triangles = np.frombuffer(mesh.faces_buffer, np.int32).reshape(-1, 3)
        styles = np.frombuffer(mesh.material_ids_buffer, np.int32)
        materials = [self.styles.number(style) for style in mesh.materials]
        place, name = f"{element.type} {element.guid}", (element.name or "").strip()
        # Names of products may be those of their type: with what tells them apart, each is an object.
        objects = (f"{brief(name, _MOST_NAME)} ({place})",) if name else ()
        to_world = np.array(element.transformation.matrix).reshape(1, 4, 4).transpose(0, 2, 1)
        for style in np.unique(styles):
            used, corners = np.unique(triangles[styles == style], return_inverse=True)
            part = MeshPart(
                positions[used],
                corners.reshape(-1, 3).astype(np.int32),
                normals[used],
                material=materials[style],
                name=place,
            )
            part = placed(part, to_world)
            yield MeshPart(
                part.positions / self.metres_per_unit,
                part.triangles,
                part.normals,
                material=part.material,
                name=part.name,
                objects=objects,
            )
