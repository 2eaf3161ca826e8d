"""Water that moves in the Cornell box, with a ball in it: light bends at a surface of waves.

Each wave of a linear surface is the sum of two standing ones, which are morph targets; their weights go by cosine and
sine of the wave's phase, so that it travels without change (Lamb, "Hydrodynamics", 1932, § 228).
"""

from dataclasses import dataclass
from math import cos, pi, sin, tanh

import numpy as np

from gpu.scene.animation.motion import Animation, Channel, Interpolation, MorphTarget, Property
from gpu.scene.builtin.cornell_box import empty_box, front_camera
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import block, sphere, surface
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Material, Scene

_HALF = (0.266, 0.274)  # metres along x and z
_DEPTH, _GAP = 0.13, 0.001  # above the floor, in which the water would else lie
_SECONDS = 4.0  # until all begins anew
_CELLS = 48  # of the surface, along each side
_KEYS_A_PERIOD = 6  # of the fastest wave: cubic splines through them leave a thousandth of its height
_GRAVITY = 9.81


@dataclass(frozen=True)
class _Wave:
    """periods: in the time of the animation; degrees: where it goes, from +X to +Z; height: from the mean [m]."""

    periods: int
    degrees: float
    height: float

    @property
    def frequency(self) -> float:
        """[rad/s]"""
        return 2.0 * pi * self.periods / _SECONDS

    @property
    def number(self) -> float:
        """Radians a metre, from ω² = g·k·tanh(k·depth) as the fixed point that steps half the way come to."""
        number = self.frequency**2 / _GRAVITY
        for _ in range(60):
            number = (number + self.frequency**2 / (_GRAVITY * tanh(number * _DEPTH))) / 2.0
        return number


_WAVES = (_Wave(9, 20.0, 0.0045), _Wave(10, 128.0, 0.0035), _Wave(12, 250.0, 0.0022), _Wave(15, 75.0, 0.0012))


def _body() -> tuple[Shape, Doubles]:
    """The water at rest, and which of its vertices are of the surface (1) or of the bottom (0), (vertex,)."""
    x, z = (np.linspace(-half, half, _CELLS + 1) for half in _HALF)
    grid = np.stack(np.meshgrid(x, [_DEPTH], z, indexing="ij"), axis=-1)[:, 0]  # (x, z, 3)
    down = np.array([1.0, 0.0, 1.0])
    edges = (grid[:, -1], grid[-1, ::-1], grid[::-1, 0], grid[0])  # counter-clockwise from above
    sides = [surface(np.stack([edge * down + (0.0, _GAP, 0.0), edge])) for edge in edges]
    floor = np.array([0.0, _GAP, 0.0])
    bottom = surface(np.stack([grid[[0, -1], 0], grid[[0, -1], -1]]) * down + floor)
    shape = join([surface(grid.transpose(1, 0, 2)[::-1]), *sides, bottom])
    return shape, (shape.positions[:, 1] > _DEPTH / 2.0).astype(np.float64)


def _targets(shape: Shape, surface_share: Doubles) -> list[MorphTarget]:
    """Each wave's cosine and sine over the places of vertices, as heights, and as slopes of the surface's normals."""
    found, faces_up = [], surface_share * (shape.normals[:, 1] > 0.5)
    for wave in _WAVES:
        along = wave.number * np.array([cos(np.radians(wave.degrees)), 0.0, sin(np.radians(wave.degrees))])
        phase = shape.positions @ along
        for height, slope in ((np.cos(phase), -np.sin(phase)), (np.sin(phase), np.cos(phase))):
            positions = np.zeros_like(shape.positions)
            positions[:, 1] = wave.height * height * surface_share
            found.append(MorphTarget(positions, -wave.height * (slope * faces_up)[:, None] * along))
    return found


def _animation() -> Animation:
    """The weights of the targets: cos(k·x − ω·t) = cos(k·x)·cos(ω·t) + sin(k·x)·sin(ω·t)."""
    keys = _KEYS_A_PERIOD * max(wave.periods for wave in _WAVES) + 1
    times = np.linspace(0.0, _SECONDS, keys)
    values, tangents = np.empty((2, keys, 2 * len(_WAVES)))
    for number, wave in enumerate(_WAVES):
        cosine, sine = np.cos(wave.frequency * times), np.sin(wave.frequency * times)
        values[:, 2 * number : 2 * number + 2] = np.stack([cosine, sine], axis=1)
        tangents[:, 2 * number : 2 * number + 2] = wave.frequency * np.stack([-sine, cosine], axis=1)
    splines = np.stack([tangents, values, tangents], axis=1)
    return Animation("waves", _SECONDS, (Channel(0, Property.WEIGHTS, Interpolation.CUBICSPLINE, times, splines),))


def make() -> Scene:
    """The box, its floor under water in which a ball lies, another swims and a pole stands."""
    builder = empty_box("water-box")
    builder.material(
        Material(
            "water",
            transmission=1.0,
            thickness=_DEPTH,
            roughness=0.0,
            ior=1.333,
            attenuation_color=(0.45, 0.8, 0.85),
            attenuation_distance=0.6,
        )
    )
    builder.paints("ball #d98a2b 1, pole #d8d4cc 1")
    builder.add("ball", sphere(0.06, 40).moved(0.1, 0.062, 0.08))
    builder.add(
        "pole", block((-0.02, 0.0, -0.02), (0.02, 0.36, 0.02)).turned(30.0).turned(16.0, "z").moved(-0.08, 0.002)
    )
    shape, share = _body()
    builder.add_moving("water", shape, _targets(shape, share), [1.0, 0.0] * len(_WAVES))
    near = look_at((0.1, 0.33, 0.62), (0.0, 0.1, 0.0), yfov_degrees=48.0, name="near")
    return builder.scene([front_camera(), near], animations=[_animation()])
