"""A glass cube with a torus inside, in the Cornell box, after the scene that papers on caustics use."""

from math import pi

import numpy as np

from gpu.scene.builtin.cornell_box import empty_box, front_camera
from gpu.scene.builtin.shape import Shape
from gpu.scene.builtin.shapes import block, lathe
from gpu.scene.camera import look_at
from gpu.scene.types import Material, Scene

_SIDE = 0.26  # metres
_GAP = 0.001  # below the cube, whose underside would else lie in the floor


def _torus(radius: float, thickness: float) -> Shape:
    """A ring about the Y axis whose middle line has `radius`, of round section with radius `thickness`."""
    angle = np.linspace(-pi, pi, 25)
    return lathe(np.stack([radius + thickness * np.cos(angle), thickness * np.sin(angle)], axis=1), 48, 60.0)


def make() -> Scene:
    """The box, in whose middle the cube stands."""
    builder = empty_box("glass-box")
    builder.material(Material("glass", transmission=1.0, thickness=_SIDE, roughness=0.0))
    builder.material(Material("torus", base_color=(0.8, 0.35, 0.08, 1.0), roughness=1.0))
    half, middle = _SIDE / 2, (0.0, _SIDE / 2 + _GAP, 0.02)
    builder.add("glass", block((-half, -half, -half), (half, half, half)).turned(24.0).moved(*middle))
    builder.add("torus", _torus(0.075, 0.03).turned(60.0, "x").turned(24.0).moved(*middle))
    near = look_at((-0.16, 0.33, 0.55), (0.0, 0.12, 0.02), yfov_degrees=50.0, name="near")
    return builder.scene([front_camera(), near])
