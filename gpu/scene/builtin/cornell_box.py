"""The Cornell box with its measured corners, in metres, turned so that the camera looks along −Z.

Source: Cornell University Program of Computer Graphics, "The Cornell Box: physical model data", 1998; the colours are
the usual Rec. 709 values for its measured spectra.
"""

import numpy as np

from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import surface
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Scene

_CENTRE = np.array([0.278, 0.0, 0.2796])


def _face(*corners: tuple[float, float, float]) -> Shape:
    """A four-sided face from corners in the data's millimetres, counter-clockwise from the front."""
    a, b, c, d = (_turned(corner) for corner in corners)
    return surface([[a, b], [d, c]])


def _turned(corner: tuple[float, float, float]) -> Doubles:
    """Metres about the middle of the floor; the data's camera looks along +Z with +X to the left."""
    return (np.array(corner) / 1000.0 - _CENTRE) * (-1.0, 1.0, -1.0)


def _block(plan: list[tuple[float, float]], height: float) -> Shape:
    """A box without its underside over four (x, z) corners of the data."""
    top = [(x, height, z) for x, z in plan]
    sides = [
        _face((plan[after][0], 0, plan[after][1]), top[after], top[number], (x, 0, z))
        for number, (x, z) in enumerate(plan)
        for after in [(number + 1) % 4]
    ]
    return join([_face(*top), *sides])


def make() -> Scene:
    """The box with its short and tall block under one area light, which hangs a millimetre below the ceiling."""
    builder = Builder("cornell-box")
    white = builder.diffuse("white", (0.725, 0.71, 0.68))
    red = builder.diffuse("red", (0.63, 0.065, 0.05))
    green = builder.diffuse("green", (0.14, 0.45, 0.091))
    light = builder.light("light", (18.4, 14.0, 6.8))

    floor = _face((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
    ceiling = _face((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))
    back = _face((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))
    short = _block([(130, 65), (82, 225), (240, 272), (290, 114)], 165)
    tall = _block([(423, 247), (265, 296), (314, 456), (472, 406)], 330)
    builder.add(white, floor, ceiling, back, short, tall)
    builder.add(red, _face((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)))
    builder.add(green, _face((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)))
    builder.add(light, _face((343, 547.8, 227), (343, 547.8, 332), (213, 547.8, 332), (213, 547.8, 227)))

    front = look_at((0.0, 0.273, 1.0796), (0.0, 0.273, 0.0), yfov_degrees=37.7, aspect=1.0, name="front")
    inside = look_at((-0.2, 0.4, 0.27), (0.08, 0.13, -0.12), yfov_degrees=60.0, name="from the red wall")
    return builder.scene([front, inside])
