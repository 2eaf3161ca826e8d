"""The package of a 3MF file: its models, their objects and resources, and what is built of them."""

from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.instances import Contents, Hierarchy
from gpu.scene.formats.package import Package
from gpu.scene.formats.threemf.unread import say_unread
from gpu.scene.formats.xml_tree import number_row, xml_root
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles

Key = tuple[str, str]
"""A resource: the file of its model in the package, and its id."""

_UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
_RELATIONS, _MODEL_TYPE = "_rels/.rels", "/3dmodel"


class Model:
    """The 3MF file at `path`, which has `content`."""

    def __init__(self, path: Path, content: bytes, limits: SceneLimits, remarks: Remarks) -> None:
        """Raises SceneError when it is no 3MF file."""
        self.path, self.limits, self.remarks = path, limits, remarks
        self.package = Package(path, content, limits)
        self._roots: dict[str, Element] = {}
        self._resources: dict[Key, Element] = {}
        self._start = self._started()
        self._read(self._start)
        self.metres_per_unit = self._metres()

    def _metres(self) -> float:
        """The unit of length; a millimetre where the file says none that is known."""
        unit = self._roots[self._start].get("unit", "millimeter")
        if unit not in _UNITS:
            self.remarks.add(f"the unit {unit!r:.40} is not known: millimetres were taken")
        return _UNITS.get(unit, _UNITS["millimeter"])

    def resource(self, key: Key) -> Element | None:
        """The resource called `key`; None, and said, when there is none."""
        self._read(key[0])
        found = self._resources.get(key)
        if found is None:
            self.remarks.add("a resource that the file refers to is not in it", repr(key[1][-40:]))
        return found

    def built(self) -> list[tuple[Doubles, Key]]:
        """The objects with a mesh that the file builds, each with its 4×4 matrix. Raises SceneError."""
        hierarchy = Hierarchy(str(self.path), self.limits, self._contents, lambda key: f"object {key[1]}")
        return [
            (matrix @ own, found)
            for item in self._roots[self._start].iterfind("build/item")
            for matrix, key in [self._use(item, self._start, "item")]
            for own, found in hierarchy.leaves(key)
        ]

    def _contents(self, key: Key) -> Contents[Key, Key]:
        found = self.resource(key)
        if found is None or found.tag != "object":
            return [], []
        if found.get("type", "model") in ("support", "solidsupport"):
            self.remarks.add("supports are not shown", f"object {key[1]}")
            return [], []
        own = [(np.eye(4), key)] if found.find("mesh") is not None else []
        inner = [self._use(part, key[0], f"object {key[1]}") for part in found.iterfind("components/component")]
        return own, inner

    def _use(self, element: Element, file: str, place: str) -> tuple[Doubles, Key]:
        """The 4×4 matrix and the object of an item or component."""
        matrix = np.eye(4)
        if "transform" in element.attrib:
            try:
                matrix[:3] = number_row(element.attrib["transform"]).reshape(4, 3).T
            except ValueError as error:
                raise SceneError(str(self.path), place, f"its transform is not 12 numbers: {error}") from error
        if not np.isfinite(matrix).all():
            raise SceneError(str(self.path), place, "its transform is not finite; repair it")
        other = element.get("path")
        if other is not None:
            file = self.package.find(other) or other
        return matrix, (file, element.get("objectid", ""))

    def _started(self) -> str:
        """The file of the model that the package begins with."""
        if relations := self.package.find(_RELATIONS):
            for relation in xml_root(str(self.path), self.package.read(relations), relations):
                found = self.package.find(relation.get("Target", ""))
                if found and relation.get("Type", "").endswith(_MODEL_TYPE):
                    return found
        for name in self.package.names:
            if name.lower().endswith(".model"):
                return name
        raise SceneError(str(self.path), "", "there is no 3D model in the .3mf")

    def _read(self, file: str) -> None:
        """Know the resources of the model in `file`, if the package has it."""
        if file in self._roots or file not in self.package.names:
            return
        root = xml_root(str(self.path), self.package.read(file), file)
        if root.tag != "model":
            raise SceneError(str(self.path), file, f"not a 3D model: its root is {root.tag!r:.40}")
        self._roots[file] = root
        for resource in root.iterfind("resources/*"):
            self._resources.setdefault((file, resource.get("id", "")), resource)
        say_unread(root, file, self.remarks)
