"""Cameras and lights of a glTF scene, in world space."""

from math import cos, pi, tan

import numpy as np

from gpu.scene.gltf.document import Document
from gpu.scene.gltf.hierarchy import PlacedNode
from gpu.scene.gltf.values import Value
from gpu.scene.transforms import rigid
from gpu.scene.types import Camera, Light, LightKind, Rgb

_KINDS = {"point": LightKind.POINT, "spot": LightKind.SPOT, "directional": LightKind.DIRECTIONAL}


def read_camera(document: Document, node: PlacedNode) -> Camera | None:
    """The camera of `node`, or None. Raises SceneError when it is broken."""
    if not node.entry.has("camera"):
        return None
    camera = document.referred(node.entry, "camera", "cameras")
    name = node.entry.text("name", "") or camera.text("name", "") or camera.path
    kind = camera.text("type")
    if kind == "perspective":
        lens = camera.get("perspective")
        half_height = tan(lens.number("yfov", low=1e-4, high=pi - 1e-4) / 2.0)
        return Camera(name, rigid(node.to_world), half_height, lens.number("aspectRatio", 16.0 / 9.0, 1e-4, 1e4))
    if kind == "orthographic":
        lens = camera.get("orthographic")
        width, height = (abs(lens.number(key, low=-1e30, high=1e30)) for key in ("xmag", "ymag"))
        if not (width > 0.0 and height > 0.0):
            raise lens.error("xmag and ymag must not be 0")
        return Camera(name, rigid(node.to_world), height, width / height, orthographic=True)
    raise camera.get("type").error(f"must be perspective or orthographic, not {kind!r:.40}")


def read_light(document: Document, node: PlacedNode) -> Light | None:
    """The KHR_lights_punctual light of `node`, or None. Raises SceneError when it is broken.

    Units are taken as radiometric: intensity [W/sr], of directional lights irradiance [W/m²].
    """
    reference = node.entry.extension("KHR_lights_punctual")
    if reference is None:
        return None
    lights = (document.root.extension("KHR_lights_punctual") or Value(document.root.source, "", {})).objects("lights")
    entry = lights[reference.get("light").as_index(len(lights))]
    kind = entry.text("type")
    if kind not in _KINDS:
        raise entry.get("type").error(f"must be one of {', '.join(_KINDS)}, not {kind!r:.40}")
    spot = entry.object("spot") if kind == "spot" else Value(entry.source, entry.path, {})
    outer = spot.number("outerConeAngle", pi / 4.0, 0.0, pi / 2.0)
    inner = spot.number("innerConeAngle", 0.0, 0.0, outer)
    color = np.array(entry.numbers("color", (1.0, 1.0, 1.0), 0.0)) * entry.number("intensity", 1.0, 0.0, 1e30)
    axes = rigid(node.to_world)
    return Light(
        name=entry.text("name", "") or node.entry.text("name", entry.path),
        kind=_KINDS[kind],
        intensity=_rgb(color),
        position=_rgb(axes[:3, 3]),
        direction=_rgb(-axes[:3, 2]),
        cos_inner=cos(inner),
        cos_outer=cos(outer),
    )


def _rgb(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Rgb:
    return (float(values[0]), float(values[1]), float(values[2]))
