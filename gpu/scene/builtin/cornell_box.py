"""The Cornell box with its measured corners, in metres, turned so that the camera looks along −Z.

Source: Cornell University Program of Computer Graphics, "The Cornell Box: physical model data", 1998; the colours are
the usual Rec. 709 values for its measured spectra.
"""

import numpy as np

from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import points, surface
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Material, Scene

_CENTRE = np.array([0.278, 0.0, 0.2796])
_COLOURS = {"white": (0.725, 0.71, 0.68), "red": (0.63, 0.065, 0.05), "green": (0.14, 0.45, 0.091)}
# Faces by their corners in the data's millimetres, counter-clockwise from the front.
_FACES = {
    "white": (
        "552.8,0,0 0,0,0 0,0,559.2 549.6,0,559.2",  # floor
        "556,548.8,0 556,548.8,559.2 0,548.8,559.2 0,548.8,0",  # ceiling
        "549.6,0,559.2 0,0,559.2 0,548.8,559.2 556,548.8,559.2",  # back
    ),
    "red": ("552.8,0,0 549.6,0,559.2 556,548.8,559.2 556,548.8,0",),
    "green": ("0,0,559.2 0,0,0 0,548.8,0 0,548.8,559.2",),
    "light": ("343,547.8,227 343,547.8,332 213,547.8,332 213,547.8,227",),
}


def _face(corners: list[tuple[float, ...]]) -> Shape:
    """A four-sided face in metres about the middle of the floor; the data's camera looks along +Z, +X to the left."""
    a, b, c, d = (np.array(corners) / 1000.0 - _CENTRE) * (-1.0, 1.0, -1.0)
    return surface([[a, b], [d, c]])


def _block(plan: str, y: float) -> Shape:
    """A box without its underside over four (x, z) corners of the data."""
    corners = points(plan)
    ring = zip(corners, [*corners[1:], corners[0]], strict=True)
    sides = [_face([(u, 0, v), (u, y, v), (x, y, z), (x, 0, z)]) for (x, z), (u, v) in ring]
    return join([_face([(x, y, z) for x, z in corners]), *sides])


def empty_box(name: str) -> Builder:
    """A scene of the box alone under one area light, which hangs a millimetre below the ceiling."""
    builder = Builder(name)
    for colour, albedo in _COLOURS.items():
        builder.material(Material(colour, base_color=(*albedo, 1.0), roughness=1.0))
    builder.light("light", (18.4, 14.0, 6.8))
    for colour, faces in _FACES.items():
        builder.add(colour, [_face(points(face)) for face in faces])
    return builder


def front_camera() -> Camera:
    """The data's camera."""
    return look_at((0.0, 0.273, 1.0796), (0.0, 0.273, 0.0), yfov_degrees=37.7, aspect=1.0, name="front")


def make() -> Scene:
    """The box with its short and tall block."""
    builder = empty_box("cornell-box")
    builder.add("white", [_block("130,65 82,225 240,272 290,114", 165), _block("423,247 265,296 314,456 472,406", 330)])
    inside = look_at((-0.2, 0.4, 0.27), (0.08, 0.13, -0.12), yfov_degrees=60.0, name="from the red wall")
    return builder.scene([front_camera(), inside])
