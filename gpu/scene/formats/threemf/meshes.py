"""Meshes of 3MF objects, a part for each of the properties that their triangles have."""

from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.outlines import usable_positions, whole
from gpu.scene.formats.threemf.model import Key, Model
from gpu.scene.formats.threemf.properties import Properties
from gpu.scene.formats.xml_tree import attribute_rows
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers
from gpu.scene.validate import check_indices

_PAINTED = ("paint_color", "mmu_segmentation")


class Meshes:
    """The meshes of a model's objects."""

    def __init__(self, model: Model, properties: Properties) -> None:
        self._model, self._properties = model, properties

    def of(self, key: Key) -> Iterator[MeshPart]:
        """The parts of the object `key`. Raises SceneError where its mesh is broken."""
        found = self._model.resource(key)
        assert found is not None
        name, source = f"object {found.get('name') or key[1]}", str(self._model.path)
        objects = (found.get("name") or name,)
        elements = found.findall("mesh/triangles/triangle")
        positions = self._rows(found.iterfind("mesh/vertices/vertex"), ("x", "y", "z"), f"{name}: vertices")
        corners = whole(self._rows(iter(elements), ("v1", "v2", "v3"), f"{name}: triangles"))
        check_indices(source, f"{name}: triangles", corners, len(positions))
        positions = usable_positions(
            source, positions, corners.reshape(-1), self._model.remarks, lambda row: f"{name}: vertex {row}"
        )
        if any(kind in element.attrib for element in elements for kind in _PAINTED):
            self._model.remarks.add("triangles painted in a slicer's own way are shown unpainted", name)
        for group, some, indices in self._groups(found, elements):
            resource = None if group is None else (key[0], group)
            for surface in self._properties.surfaces(resource, indices):
                triangles = corners[some[surface.triangles]]
                yield MeshPart(
                    positions=positions[triangles.reshape(-1)],
                    triangles=np.arange(triangles.size).reshape(-1, 3),
                    uvs=() if surface.uvs is None else (surface.uvs,),
                    colors=surface.colors,
                    material=surface.material,
                    name=name,
                    objects=objects,
                )

    def _rows(self, elements: Iterator[Element], names: tuple[str, ...], place: str) -> Doubles:
        try:
            return attribute_rows(elements, names)
        except KeyError as error:
            raise SceneError(str(self._model.path), place, f"one has no {error.args[0]}") from error
        except ValueError as error:
            raise SceneError(
                str(self._model.path), place, f"needs numbers, with points for decimals: {error}"
            ) from error

    def _groups(self, found: Element, elements: list[Element]) -> Iterator[tuple[str | None, Integers, Integers]]:
        """The property groups that triangles have: id, which triangles, and indices (triangle, 3) in the group."""
        default, first = found.get("pid"), found.get("pindex", "0")
        groups: dict[str | None, list[int]] = {}
        for number, element in enumerate(elements):
            groups.setdefault(element.get("pid", default) if "p1" in element.attrib else default, []).append(number)
        for group, numbers in groups.items():
            words = []
            for number in numbers:
                element = elements[number]
                one = element.get("p1", first)
                words += [one, element.get("p2", one), element.get("p3", one)]
            indices = np.array([int(word) if word.isdecimal() else -1 for word in words], np.int64)
            yield group, np.array(numbers, np.int64), indices.reshape(-1, 3)
