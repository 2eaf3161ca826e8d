"""Parts of a classical colonnade: fluted columns with leafy capitals, arcades, balusters, a fountain. In metres."""

from dataclasses import replace
from math import pi

import numpy as np

from gpu.scene.builtin.furnishings import aim, leaf
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import box, lathe, moulding, points, polar, sphere, surface


def column(height: float, radius: float) -> Shape:
    """A column on the origin: plinth, Attic base, fluted shaft with entasis, capital of two rows of leaves, abacus."""
    abacus, neck, top = 0.32 * radius, height - 2.42 * radius, radius * 0.84
    plinth = box((2.75 * radius, 0.3 * radius, 2.75 * radius), 0.006).moved(0, 0.15 * radius + 0.0005, 0)
    base = "0,.29 1.16,.3 1.26,.33 1.29,.43 1.26,.53 1.16,.56 1.07,.6 1.04,.69 1.07,.76 1.12,.78 1.15,.85 1.12,.92 .9,1"
    rise = np.linspace(0.0, 1.0, 8)
    bell = [(top, neck - 0.002), (top * 1.1, neck + 0.01), (top * 1.14, neck + 0.03), (top * 1.06, neck + 0.045)]
    bell += zip(top * (0.98 + 0.42 * rise**3.5), neck + 0.05 + (2.1 * radius - 0.05) * rise, strict=True)
    parts = [plinth, lathe(np.array(points(base)) * radius, 36, 60.0), _shaft(radius, 0.94 * radius, neck), lathe(bell)]
    for share, turn in ((0.48, 0.0), (0.82, 22.5)):
        parts.append(_leaf(top, 2.1 * radius * share).at([(0, neck + 0.05, 0)] * 8, turn + 45.0 * np.arange(8)))
    slab = box((2.65 * radius, abacus, 2.65 * radius), 0.008).moved(0, height - abacus / 2, 0)
    return join([*parts, slab])


def _shaft(radius: float, low: float, high: float) -> Shape:
    """A shaft of 20 flutes, which run out below its ends."""
    step = np.arange(101) % 100
    hollow = np.array([0.0, 0.0, 0.81, 1.0, 0.81])[step % 5]
    y = np.array([0.0, 0.03, 0.06, 0.09, 0.25, 0.5, 0.75, 0.937, 0.958, 0.979, 1.0])[:, None]
    depth = 0.085 * np.interp(np.minimum(y, (1.0 - y) / 0.7), [0.03, 0.06], [0.0, 1.0])
    width = 1.0 - 0.16 * y**1.6 + 0.06 * np.exp(-y * 60.0) + 0.05 * np.exp((y - 1.0) * 70.0)
    return surface(polar(pi * step / 50, radius * width * (1.0 - depth * hollow), low + (high - low) * y), 30.0)


def _leaf(radius: float, height: float) -> Shape:
    """A leaf that stands up against a bell at +Z and curls outwards at its tip."""
    t, s = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(-1.0, 1.0, 7), indexing="ij")
    half = 0.4 * radius * np.sqrt(1.0 - t**4) * (1.0 - 0.16 * np.abs(np.sin(t * pi * 3.5))) + 0.002
    curl = np.clip(t - 0.6, 0.0, 1.0) / 0.4
    out = radius * (1.06 + 0.1 * t + 0.46 * curl**2 - 0.12 * s**2)
    return surface(np.stack([-s * half, height * (t - 0.3 * curl**3), out], axis=-1)[:, ::-1], 60.0)


def arch(width: float, height: float, thick: float) -> tuple[Shape, Shape]:
    """A bay of an arcade about the origin at its springing: (wall above a semicircular arch, its mouldings)."""
    radius, angle = width / 2 - 0.23, np.linspace(0.0, pi, 29)
    arc = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    foot = np.insert([(width / 2, 0.0), *arc, (-width / 2, 0.0)], 2, thick / 2, axis=1)[::-1]
    front = surface([foot, np.array([(x, height, z) for x, _, z in foot])])
    front = replace(front, uvs=front.positions[:, :2] * (1, -1))
    wall = join([front, front.turned(180), surface([foot * (1, 1, -1), foot], 25.0)])
    section = points("-.2,-.01 -.2,.035 -.17,.05 -.15,.03 -.08,.0275 -.07,.02 .006,.0175 .006,-.01")
    rim = moulding(section, arc * (1, -1), closed=False).turned(90, "x")
    trim = join([rim, box((0.2, 0.34, 0.12), 0.012).moved(0, radius + 0.12, 0.02)]).moved(z=thick / 2)
    return wall, join([trim, trim.turned(180)])


def baluster() -> Shape:
    """A turned baluster on the origin, 0.662 m high."""
    belly = ".036,.07 .058,.13 .068,.21 .064,.29 .048,.39 .033,.46 .03,.53 .03,.592"
    return lathe(points(f".07,0 .07,.05 .05,.06 {belly} .05,.602 .07,.612 .07,.662"), 14)


def fountain(radius: float) -> tuple[Shape, Shape]:
    """An octagonal basin with two bowls on a pedestal in it, on the origin: (stone, water)."""
    octagon = polar(2 * pi * (np.arange(8) + 0.5) / 8, radius)[:, [0, 2]]
    rim = "-.03,-.01 -.03,.06 0,.09 .03,.1 .03,.34 0,.38 -.04,.4 -.045,.45 -.035,.46 .235,.46 .245,.45 .2,.38 .2,-.01"
    stem = "0,0 .24,0 .24,.06 .17,.1 .1,.2 .085,.4 .11,.62 .15,.68 .1,.72"
    lower = ".1,.74 .2,.748 .31,.775 .42,.82 .52,.88 .6,.94 .615,.95 .61,.965 .585,.965 .57,.95 .3,.86 .07,.84"
    upper = ".06,.95 .05,1.1 .075,1.2 .06,1.25 .14,1.26 .21,1.3 .26,1.34 .25,1.352 .12,1.3 .04,1.3"
    bowls = lathe(points(f"{stem} {lower} {upper} .05,1.36 .075,1.42 .05,1.5 0,1.53"), 56)
    pools = [lathe([(width, y), (0, y)], 48) for width, y in ((0.568, 0.948), (0.2, 1.335))]
    basin = lathe([(radius - 0.2, 0.33), (0, 0.33)], 8).turned(22.5)
    return join([moulding(points(rim), octagon), bowls]), join([basin, *pools])


def topiary(seed: int, radius: float) -> tuple[Shape, Shape]:
    """A clipped ball of 700 leaves about the origin, and the darkness within it: (leaves, core)."""
    rng = np.random.default_rng(seed)
    yaw, up = rng.uniform(-180.0, 180.0, 700), rng.uniform(-1.0, 1.0, 700)
    out = polar(np.radians(yaw - 90.0), np.sqrt(1.0 - up**2), up) * radius * rng.uniform(0.86, 0.97, 700)[:, None]
    tilt = np.degrees(np.arcsin(up)) + rng.normal(0.0, 30.0, 700)
    turns = aim(yaw + rng.normal(0.0, 40.0, 700), tilt, rng.uniform(-60.0, 60.0, 700))
    return leaf(radius * 0.22, radius * 0.13, 0.2, 3, 5).copies(out, turns), sphere(radius * 0.88, 40)
