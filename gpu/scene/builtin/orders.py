"""Parts of a classical colonnade: fluted columns with leafy capitals, arcades, balusters, a fountain. In metres."""

from dataclasses import replace
from math import pi

import numpy as np

from gpu.scene.builtin.furnishings import aim, leaf
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import Points, box, lathe, moulding, points, polar, sphere, surface
from gpu.scene.types import Doubles


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


def arch_bay(width: float, radius: float, height: float, thick: float) -> Shape:
    """A bay of an arcade about the origin at its springing: wall above a semicircular arch, `thick` along Z."""
    arc = _arc(radius)
    foot = np.array([(width / 2, 0.0), *arc, (-width / 2, 0.0)])[::-1]
    foot = np.insert(foot, 2, thick / 2, axis=1)
    front = surface([foot, foot * (1, 0, 1) + (0, height, 0)])
    front = replace(front, uvs=front.positions[:, :2] * (1, -1))
    return join([front, front.turned(180), surface([foot * (1, 1, -1), foot], 25.0)])


def archivolt(radius: float, width: float, depth: float) -> Shape:
    """The moulding on the face of an arch, to be laid on a wall at z = 0, facing +Z."""
    section = np.array(points("-1,0 -1,.7 -.85,1 -.75,.6 -.4,.55 -.35,.4 .03,.35 .03,0")) * (width, depth)
    return moulding(section - (0, 0.01), _arc(radius) * (1, -1), closed=False).turned(90, "x")


def _arc(radius: float) -> Doubles:
    """A semicircle (29, 2) of (x, y) from right to left over the origin."""
    angle = np.linspace(0.0, pi, 29)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def baluster(height: float) -> Shape:
    """A turned baluster on the origin."""
    t = np.linspace(0.0, 1.0, 10)
    belly = 0.036 + 0.034 * np.sin(pi * np.clip(t * 1.5, 0, 1)) ** 1.3 - 0.006 * t
    shaft = zip(belly, 0.07 + (height - 0.14) * t, strict=True)
    ends = [(0.05, height - 0.06), (0.07, height - 0.05), (0.07, height)]
    return lathe([*points(".07,0 .07,.05 .05,.06"), *shaft, *ends], 14)


def fountain(radius: float) -> tuple[Shape, Shape]:
    """An octagonal basin with two bowls on a pedestal in it, on the origin: (stone, water)."""
    octagon = polar(2 * pi * (np.arange(8) + 0.5) / 8, radius)[:, [0, 2]]
    rim = "-.03,-.01 -.03,.06 0,.09 .03,.1 .03,.34 0,.38 -.04,.4 -.045,.45 -.035,.46 .235,.46 .245,.45 .2,.38 .2,-.01"
    bowls = points("0,0 .24,0 .24,.06 .17,.1 .1,.2 .085,.4 .11,.62 .15,.68 .1,.72")
    bowls += _flare(0.1, 0.5, 0.74, 0.2)
    bowls += points(".615,.95 .61,.965 .585,.965 .57,.95 .3,.86 .07,.84 .06,.95 .05,1.1 .075,1.2 .06,1.24")
    bowls += _flare(0.06, 0.2, 1.25, 0.09)
    bowls += points(".265,1.35 .25,1.352 .12,1.3 .04,1.3 .05,1.36 .075,1.42 .05,1.5 0,1.53")
    pools = [lathe([(width, y), (0, y)], 48) for width, y in ((0.568, 0.948), (0.2, 1.335))]
    basin = lathe([(radius - 0.2, 0.33), (0, 0.33)], 8).turned(22.5)
    return join([moulding(points(rim), octagon), lathe(bowls, 56)]), join([basin, *pools])


def _flare(radius: float, spread: float, y: float, rise: float) -> Points:
    """The underside of a bowl from its stem outwards."""
    return [(radius + spread * a**0.65, y + rise * a**1.8) for a in np.linspace(0.0, 1.0, 14)]


def urn(height: float) -> Shape:
    """An amphora-like urn on the origin."""
    t = np.linspace(0.0, 1.0, 21)
    belly = zip(0.1 + 0.2 * np.sin(pi * t**0.75) ** 1.2 * (1 - 0.3 * t), 0.12 + 0.7 * t, strict=True)
    lip = points(".1,.9 .18,.97 .18,1 .15,1 .08,.88 0,.86")
    return lathe(np.array([*points("0,0 .17,0 .17,.03 .08,.08"), *belly, *lip]) * height, 48)


def topiary(seed: int, radius: float) -> tuple[Shape, Shape]:
    """A clipped ball of 700 leaves about the origin, and the darkness within it: (leaves, core)."""
    rng = np.random.default_rng(seed)
    out = rng.standard_normal((700, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    yaw = np.degrees(np.arctan2(out[:, 0], out[:, 2])) + rng.normal(0.0, 40.0, 700)
    pitch = np.degrees(np.arcsin(out[:, 1])) + rng.normal(0.0, 30.0, 700)
    turns = aim(yaw, pitch, rng.uniform(-60.0, 60.0, 700))
    places = out * radius * rng.uniform(0.86, 0.97, 700)[:, None]
    return leaf(radius * 0.22, radius * 0.13, 0.2, 3, 5).copies(places, turns), sphere(radius * 0.88, 40)
