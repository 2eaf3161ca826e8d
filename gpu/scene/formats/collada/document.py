"""A COLLADA file while it is read: its elements by their ids, its numbers, the files that it refers to."""

import posixpath
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePosixPath
from urllib.parse import unquote
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.files import read_bytes, read_uri
from gpu.scene.formats.package import Package
from gpu.scene.formats.xml_tree import number_row, text_of, xml_root
from gpu.scene.import_options import Axis
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles

# Right is −Y and up is X: turned to have Y up.
_X_UP = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Document:
    """The file at `path`. package: the .zae that it is in, as `entry`; remarks: for the report."""

    path: Path
    root: Element
    limits: SceneLimits
    package: Package | None = None
    entry: str = ""
    remarks: Remarks = field(default_factory=Remarks)

    @cached_property
    def _ids(self) -> dict[str, Element]:
        found: dict[str, Element] = {}
        for element in self.root.iter():
            if "id" in element.attrib:
                found.setdefault(element.attrib["id"], element)
        return found

    def find(self, url: str | None, tag: str) -> Element | None:
        """The element called `tag` that `url`, "#id" or "id", names; None, and said, when there is none."""
        found = self._ids.get(unquote((url or "").removeprefix("#")))
        if found is None or found.tag != tag:
            self.remarks.add(f"no {tag} of that name is in the file, which refers to it", repr((url or "")[-60:]))
            return None
        return found

    def numbers(self, element: Element | None, place: str, count: int | None = None) -> Doubles:
        """The numbers (number,) in `element`. Raises SceneError when they are none, or not `count`."""
        try:
            values = number_row(text_of(element))
        except ValueError as error:
            raise SceneError(str(self.path), place, f"needs numbers, with points for decimals: {error}") from error
        if count is not None and len(values) != count:
            raise SceneError(str(self.path), place, f"needs {count} numbers, not {len(values)}")
        return values

    def value(self, element: Element | None, default: float, place: str) -> float:
        """The number in `element`; `default`, and said, where there is one that cannot be read."""
        if element is None:
            return default
        try:
            value = float(text_of(element))
        except ValueError:
            value = float("nan")
        if not np.isfinite(value):
            self.remarks.add(f"{element.tag} is no number: {default:g} was taken", place)
            return default
        return value

    def content(self, uri: str, place: str) -> bytes:
        """What the file `uri` holds, beside the scene or in its package. Raises SceneError."""
        if self.package is None or uri[:5].lower() == "data:":
            return read_uri(self.path, uri, place, self.limits, self.remarks)
        beside = posixpath.normpath(posixpath.join(posixpath.dirname(self.entry), unquote(uri).replace("\\", "/")))
        for name in (beside, PurePosixPath(beside).name):
            if found := self.package.find(name):
                return self.package.read(found)
        raise SceneError(str(self.path), place, f"{uri[-60:]!r} does not exist in the package")

    @cached_property
    def metres_per_unit(self) -> float | None:
        """What the file says, None where it says nothing that can be used."""
        unit = self.root.find("asset/unit")
        if unit is None or "meter" not in unit.attrib:
            return None
        try:
            metres = float(unit.attrib["meter"])
        except ValueError:
            metres = 0.0
        if not (np.isfinite(metres) and metres > 0.0):
            self.remarks.add(f"the unit of length is no number of metres: {unit.attrib['meter']!r:.40}")
            return None
        return metres

    @property
    def up(self) -> Axis | None:
        """The axis that is up; "y" of a file with X up, which `turn` turns."""
        axes: dict[str, Axis] = {"X_UP": "y", "Y_UP": "y", "Z_UP": "z"}
        said = text_of(self.root.find("asset/up_axis"))
        if said and said.upper() not in axes:
            self.remarks.add(f"the axis that is up is not known: {said!r:.40}; it is none of {', '.join(axes)}")
        return axes.get(said.upper())

    @property
    def turn(self) -> Doubles:
        """The 4×4 matrix from the file's axes to ones that `up` can tell."""
        return _X_UP if text_of(self.root.find("asset/up_axis")).upper() == "X_UP" else np.eye(4)


def open_document(path: Path, limits: SceneLimits) -> Document:
    """The COLLADA file at `path`, or the one in a .zae there. Raises SceneError when it is none."""
    content = read_bytes(path, limits)
    if path.suffix.lower() != ".zae":
        return Document(path, _root(path, content), limits)
    package = Package(path, content, limits)
    entry = _entry(package)
    return Document(path, _root(path, package.read(entry)), limits, package, entry)


def _root(path: Path, content: bytes) -> Element:
    root = xml_root(str(path), content)
    if root.tag != "COLLADA":
        raise SceneError(str(path), "", f"not a COLLADA file: its root is {root.tag!r:.40}")
    return root


def _entry(package: Package) -> str:
    """The .dae file that the manifest of a .zae names, else its first one."""
    if manifest := package.find("manifest.xml"):
        root = xml_root(str(package.path), package.read(manifest), manifest)
        named = text_of(next(root.iter("dae_root"), None))
        if found := package.find(unquote(named.partition("#")[0].removeprefix("./"))):
            return found
    for name in package.names:
        if name.lower().endswith(".dae") and "__MACOSX" not in name:
            return name
    raise SceneError(str(package.path), "", "there is no .dae file in the .zae")
