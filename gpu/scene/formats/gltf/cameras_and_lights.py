"""Cameras and lights of a glTF scene, in world space."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from math import cos, inf, pi, tan

import numpy as np

from gpu.scene.floats import triple
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.hierarchy import PlacedNode
from gpu.scene.formats.gltf.values import Value
from gpu.scene.transforms import rigid
from gpu.scene.types import Camera, Doubles, Light, LightKind

_KINDS = {"point": LightKind.POINT, "spot": LightKind.SPOT, "directional": LightKind.DIRECTIONAL}
_FAR = 1e30  # where a view begins at the farthest [m]
_MOST = 1e30  # W/sr: so that float32 holds what is computed with it
_EXTENSION = "KHR_lights_punctual"


@dataclass(frozen=True)
class PlacedLight:
    """A light, its number in the file, and that of its node."""

    light: Light
    number: int
    node: int


def read_cameras(document: Document, nodes: Iterable[PlacedNode], bounds: Doubles) -> list[tuple[Camera, int]]:
    """The cameras of `nodes`, with their nodes' numbers; those that are broken are left out and said.

    bounds: the corners (corner, 3) of a box around what they see; one that ends its view before that (zfar) is noted.
    """
    placed = (node for node in nodes if node.entry.has("camera"))
    found = ((document.attempt(partial(_camera, document, it, bounds), "the camera"), it.number) for it in placed)
    return [(camera, number) for camera, number in found if camera is not None]


def read_lights(document: Document, nodes: Iterable[PlacedNode]) -> list[PlacedLight]:
    """The KHR_lights_punctual lights of `nodes`; broken ones are left out and said.

    Units are taken as radiometric: intensity [W/sr], of directional lights irradiance [W/m²].
    """
    placed = (node for node in nodes if node.visible and node.entry.part("extensions").has(_EXTENSION))
    found = (document.attempt(partial(_light, document, it), "the light") for it in placed)
    return [light for light in found if light is not None]


def _camera(document: Document, node: PlacedNode, bounds: Doubles) -> Camera:
    camera = document.referred(node.entry, "camera", "cameras")
    name = node.entry.name(camera.name(f"camera {node.entry.integer('camera')}"))
    kind = camera.text("type")
    far = camera.part(kind).factor("zfar", inf, 0.0)
    towards = -rigid(node.to_world)[:3, 2]
    if len(bounds) and float(((bounds - node.to_world[:3, 3]) @ towards).max()) > far:
        document.notes.add("what lies beyond its far plane (zfar) is shown all the same", name)
    if kind == "perspective":
        lens = camera.get("perspective")
        half_height = tan(lens.number("yfov", low=1e-4, high=pi - 1e-4) / 2.0)
        aspect = lens.factor("aspectRatio", 16.0 / 9.0, 1e-4, 1e4)
        return Camera(name, rigid(node.to_world), half_height, aspect, near=lens.factor("znear", 0.0, 0.0, _FAR))
    if kind == "orthographic":
        lens = camera.get("orthographic")
        width, height = (abs(lens.number(key, low=-1e30, high=1e30)) for key in ("xmag", "ymag"))
        if not (width > 0.0 and height > 0.0):
            raise lens.error("xmag and ymag must not be 0")
        near = lens.factor("znear", 0.0, 0.0, _FAR)
        return Camera(name, rigid(node.to_world), height, width / height, orthographic=True, near=near)
    raise camera.get("type").error(f"must be perspective or orthographic, not {kind!r:.40}")


def _light(document: Document, node: PlacedNode) -> PlacedLight:
    own = node.entry.named_extension(_EXTENSION)
    entry = document.root.named_extension(_EXTENSION).element("lights", own, "light")
    number = own.integer("light")
    kind = entry.text("type")
    if kind not in _KINDS:
        raise entry.get("type").error(f"must be one of {', '.join(_KINDS)}, not {kind!r:.40}")
    spot = entry.part("spot") if kind == "spot" else Value(entry.source, entry.path, {})
    outer = spot.factor("outerConeAngle", pi / 4.0, 0.0, pi / 2.0)
    inner = spot.factor("innerConeAngle", 0.0, 0.0, outer)
    color = np.array(entry.factors("color", (1.0, 1.0, 1.0), 0.0, _MOST)) * entry.factor("intensity", 1.0, 0.0, _MOST)
    if entry.has("range") and kind != "directional":
        problem = "its range was ignored: light has no end but falls with the square of the distance"
        document.ignored.add(problem, entry.name(entry.path), kind="range")
    axes = rigid(node.to_world)
    light = Light(
        name=entry.name() or node.entry.name(f"light {number}"),
        kind=_KINDS[kind],
        intensity=triple(np.minimum(color, _MOST)),
        position=triple(axes[:3, 3]),
        direction=triple(-axes[:3, 2]),
        cos_inner=cos(inner),
        cos_outer=cos(outer),
    )
    return PlacedLight(light, number, node.number)
