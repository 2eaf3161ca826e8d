"""Lights and cameras of COLLADA, as its common profile has them."""

from collections.abc import Iterator
from math import atan, cos, degrees, radians, tan
from xml.etree.ElementTree import Element

import numpy as np

from gpu.scene.floats import triple
from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.collada.nodes import Instance
from gpu.scene.transforms import rigid
from gpu.scene.types import Camera, Light, LightKind

_KINDS = {"point": LightKind.POINT, "spot": LightKind.SPOT, "directional": LightKind.DIRECTIONAL}
_ASPECT = 16.0 / 9.0


def read_light(document: Document, instance: Instance) -> Iterator[Light]:
    """The light of an instance; none, and said, of ambient light and others that are not shown.

    Colours have no unit in COLLADA: they are taken as W/sr or, of directional lights, W/m².
    """
    found = document.find(instance.url, "light")
    if found is None:
        return
    said = next(iter(found.find("technique_common") or ()), None)
    if said is None or said.tag not in _KINDS:
        kind = "unknown" if said is None else said.tag
        document.remarks.add(f"lights of kind {kind} are not shown", instance.node)
        return
    color = document.numbers(said.find("color"), f"light {instance.node}: color")[:3]
    if len(color) < 3 or not np.isfinite(color).all():
        document.remarks.add("a light without a colour was taken as white", instance.node)
        color = np.ones(3)
    if said.tag != "directional" and any(
        document.value(said.find(f"{kind}_attenuation"), default, instance.node)
        for kind, default in (("linear", 0.0), ("quadratic", 0.0))
    ):
        document.remarks.add("lights fade with the square of the distance, whatever their attenuation", instance.node)
    outer = radians(np.clip(document.value(said.find("falloff_angle"), 180.0, instance.node), 0.0, 180.0)) / 2.0
    soft = document.value(said.find("falloff_exponent"), 0.0, instance.node) > 0.0
    yield Light(
        name=instance.node,
        kind=_KINDS[said.tag],
        intensity=triple(np.maximum(color, 0.0)),
        position=triple(instance.to_world[:3, 3]),
        direction=triple(-rigid(instance.to_world)[:3, 2]),
        cos_inner=1.0 if soft else cos(outer),
        cos_outer=cos(outer),
    )


def read_camera(document: Document, instance: Instance) -> Iterator[Camera]:
    """The camera of an instance; none, and said, where it has no extent."""
    found = document.find(instance.url, "camera")
    if found is None:
        return
    said = next(iter(found.find("optics/technique_common") or ()), None)
    orthographic = said is not None and said.tag == "orthographic"
    half_height, aspect = (0.0, 0.0) if said is None else _extent(document, said, instance.node)
    if half_height <= 0.0 or aspect <= 0.0:
        document.remarks.add("a camera without a field of view was left out", instance.node)
        return
    yield Camera(instance.node, rigid(instance.to_world), half_height, aspect, orthographic)


def _extent(document: Document, said: Element, node: str) -> tuple[float, float]:
    """Half of the view's height, at distance 1 or in units, and width over height; 0 for what is none."""

    def half(axis: str) -> float | None:
        if said.tag == "orthographic":
            element = said.find(f"{axis}mag")
            return None if element is None else document.value(element, 0.0, node)
        element = said.find(f"{axis}fov")
        if element is None:
            return None
        angle = document.value(element, degrees(2.0 * atan(0.5)), node)
        return tan(radians(angle) / 2.0) if 0.0 < angle < 180.0 else 0.0

    width, height = half("x"), half("y")
    aspect = document.value(said.find("aspect_ratio"), 0.0, node)
    if width is not None and height is not None:
        return height, width / height if height > 0.0 else 0.0
    aspect = aspect if aspect > 0.0 else _ASPECT
    if height is not None:
        return height, aspect
    return (width or 0.0) / aspect, aspect
