"""Nodes of a COLLADA scene: what they instantiate, and where."""

from dataclasses import dataclass
from math import radians, tan
from xml.etree.ElementTree import Element

import numpy as np
from trimesh.transformations import rotation_matrix

from gpu.errors import SceneError
from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.instances import Contents, Hierarchy
from gpu.scene.geometry.normals import unit_rows
from gpu.scene.types import Doubles
from gpu.scene.validate import FARTHEST, check_finite, check_size

_SHOWN = ("instance_geometry", "instance_controller", "instance_light", "instance_camera")
_COUNTS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "skew": 7, "lookat": 9}


@dataclass(frozen=True, eq=False)
class Instance:
    """One use of a geometry, controller, light or camera. element: what uses it; to_world: 4×4, the file's axes; node:
    what that is called where it is used, else what is used.
    """

    element: Element
    to_world: Doubles
    node: str

    @property
    def kind(self) -> str:
        """The name of `element`."""
        return self.element.tag

    @property
    def url(self) -> str | None:
        """What is used."""
        return self.element.get("url")


def placed_instances(document: Document) -> list[Instance]:
    """All that the file's scene instantiates. Raises SceneError for a broken transform or too many instances."""
    hierarchy = Hierarchy(str(document.path), document.limits, lambda node: _contents(document, node), _name)
    return [
        Instance(element, document.turn @ matrix, node)
        for top in _scene(document).findall("node")
        for matrix, (element, node) in hierarchy.leaves(top)
    ]


def _contents(document: Document, node: Element) -> Contents[tuple[Element, str], Element]:
    """What `node` instantiates, and the nodes in it, all under its transform."""
    matrix, name = np.eye(4), _name(node)
    for child in node:
        if child.tag in _COUNTS:
            matrix = matrix @ _transform(document, child, name)
    used = (document.find(child.get("url"), "node") for child in node.findall("instance_node"))
    inner = [*node.findall("node"), *(found for found in used if found is not None)]
    shown = [
        (child, _said_name(node) or (child.get("url") or name).lstrip("#")) for child in node if child.tag in _SHOWN
    ]
    return [(matrix, leaf) for leaf in shown], [(matrix, found) for found in inner]


def _scene(document: Document) -> Element:
    """The visual scene that is shown, else the first one. Raises SceneError when there is none."""
    named = document.root.find("scene/instance_visual_scene")
    scene = None if named is None else document.find(named.get("url"), "visual_scene")
    if scene is None:
        scene = document.root.find("library_visual_scenes/visual_scene")
    if scene is None:
        raise SceneError(str(document.path), "", "there is no visual scene in it")
    return scene


def _name(node: Element) -> str:
    return _said_name(node) or "node"


def _said_name(node: Element) -> str | None:
    return node.get("name") or node.get("id")


def _transform(document: Document, element: Element, node: str) -> Doubles:
    """The 4×4 matrix of an element; angles in degrees."""
    values = document.numbers(element, f"{node}: {element.tag}", _COUNTS[element.tag])
    check_finite(str(document.path), f"{node}: {element.tag}", values)
    check_size(str(document.path), f"{node}: {element.tag}", values, FARTHEST)
    matrix = np.eye(4)
    if element.tag == "matrix":
        return values.reshape(4, 4)
    if element.tag == "translate":
        matrix[:3, 3] = values
    elif element.tag == "scale":
        matrix[:3, :3] = np.diag(values)
    elif element.tag == "rotate":
        if values[:3].any():
            matrix = rotation_matrix(radians(values[3]), values[:3])
    elif element.tag == "skew":  # RenderMan's: the second axis leans towards the first
        along, leaning = values[4:7], values[1:4]
        matrix[:3, :3] += tan(radians(values[0])) * np.outer(*unit_rows(np.stack([along, leaning]))[0])
    else:
        eye, target, up = values.reshape(3, 3)
        back = eye - target
        right = np.cross(up, back)
        matrix[:3, :3] = unit_rows(np.stack([right, np.cross(back, right), back]))[0].T
        matrix[:3, 3] = eye
    return matrix
