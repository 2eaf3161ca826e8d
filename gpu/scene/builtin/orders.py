"""Parts of a classical colonnade: fluted columns with leafy capitals, arcades, balusters, a fountain. In metres."""

from math import pi

import numpy as np

from gpu.scene.builtin.shape import Shape, copies, join, rotation
from gpu.scene.builtin.shapes import box, lathe, moulding, surface
from gpu.scene.types import Doubles


def column(height: float, radius: float, flutes: int = 20) -> Shape:
    """A column on the origin: plinth, Attic base, fluted shaft with entasis, capital of two rows of leaves, abacus."""
    plinth, base, capital, abacus = 0.3 * radius, 0.65 * radius, 2.1 * radius, 0.32 * radius
    foot = plinth + base
    neck = height - capital - abacus
    slab = box((2.75 * radius, plinth, 2.75 * radius), 0.006).moved(0, plinth / 2 + 0.0005, 0)
    rings = lathe([(0, plinth - 0.002), *_attic_base(radius, plinth, base), (radius * 0.9, foot + 0.01)], 36)
    shaft = _shaft(radius, foot - 0.002, neck, flutes)
    top = radius * 0.84
    bell_profile = [
        (top, neck - 0.002),
        (top * 1.1, neck + 0.01),
        (top * 1.14, neck + 0.03),
        (top * 1.06, neck + 0.045),
    ]
    rise = np.linspace(0.0, 1.0, 8)
    bell_profile += [(top * (0.98 + 0.42 * a**3.5), neck + 0.05 + (capital - 0.05) * a) for a in rise]
    bell = lathe(bell_profile, 32)
    leaves = join(
        [_leaf_ring(top, neck + 0.05, capital * share, 8, turn) for share, turn in ((0.48, 0.0), (0.82, 22.5))]
    )
    plates = [
        box((2.5 * radius, abacus * 0.55, 2.5 * radius), 0.006).moved(0, height - 0.72 * abacus, 0),
        box((2.65 * radius, abacus * 0.5, 2.65 * radius), 0.008).moved(0, height - 0.25 * abacus, 0),
    ]
    return join([slab, rings, shaft, bell, leaves, *plates])


def _attic_base(radius: float, low: float, height: float) -> list[tuple[float, float]]:
    """The profile of torus, scotia, torus."""
    turn = np.linspace(-pi / 2, pi / 2, 7)
    lower = [(radius * 1.16 + 0.2 * height * np.cos(a), low + height * (0.2 + 0.2 * np.sin(a))) for a in turn]
    scotia = [(radius * 1.14 - 0.1 * height * np.cos(a), low + height * (0.57 + 0.13 * np.sin(a))) for a in turn]
    upper = [(radius * 1.04 + 0.12 * height * np.cos(a), low + height * (0.84 + 0.12 * np.sin(a))) for a in turn]
    return [*lower, *scotia, *upper, (radius * 1.0, low + height)]


def _shaft(radius: float, low: float, high: float, flutes: int) -> Shape:
    """The fluted shaft; the flutes run out below its ends."""
    per = 5
    step = np.arange(flutes * per + 1) % (flutes * per)
    within = (step % per) / per
    hollow = np.where(within > 0, np.sin(pi * np.clip((within - 1 / per) / (1 - 1 / per), 0, 1)) ** 0.6, 0.0)
    angle = 2 * pi * step / (flutes * per)
    ends = np.array([0.0, 0.03, 0.06, 0.09])
    y = np.concatenate([ends, np.linspace(0.25, 0.75, 3), 1.0 - 0.7 * ends[::-1]])
    depth = 0.085 * np.interp(np.minimum(y, (1.0 - y) / 0.7), [0.03, 0.06], [0.0, 1.0])
    width = 1.0 - 0.16 * y**1.6 + 0.06 * np.exp(-y * 60.0) + 0.05 * np.exp((y - 1.0) * 70.0)
    ring = radius * width[:, None] * (1.0 - depth[:, None] * hollow)
    heights = np.broadcast_to((low + (high - low) * y)[:, None], ring.shape)
    return surface(np.stack([ring * np.cos(angle), heights, -ring * np.sin(angle)], axis=-1), 30.0)


def _leaf_ring(radius: float, low: float, height: float, count: int, turn: float) -> Shape:
    """A ring of leaves that stand up against a bell and curl outwards at their tips."""
    t, s = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(-1.0, 1.0, 7), indexing="ij")
    lobes = 1.0 - 0.16 * np.abs(np.sin(t * pi * 3.5))
    half = 0.4 * radius * np.sqrt(np.clip(1.0 - t**4, 0.0, 1.0)) * lobes + 0.002
    curl = np.clip(t - 0.6, 0.0, 1.0) / 0.4
    out = (
        radius * (1.06 + 0.1 * t + 0.46 * curl**2) - 0.12 * radius * s**2 + 0.05 * radius * (1 - np.abs(s)) * (t < 0.9)
    )
    up = height * (t - 0.3 * curl**3)
    one = surface(np.stack([-s * half, up, out], axis=-1)[:, ::-1], 60.0).moved(y=low)
    return copies(one, np.zeros((count, 3)), [rotation(turn + 360.0 * number / count, "y") for number in range(count)])


def arch_bay(width: float, radius: float, height: float, thick: float) -> Shape:
    """A bay of an arcade about the origin at its springing: wall above a semicircular arch, `thick` along Z."""
    x, y = _arc(radius)
    x = np.concatenate([[width / 2], x, [-width / 2]])
    y = np.concatenate([[y[0]], y, [y[-1]]])
    foot = np.stack([x, y, np.full_like(x, thick / 2)], axis=1)[::-1]
    head = np.stack([x, np.full_like(x, height), np.full_like(x, thick / 2)], axis=1)[::-1]
    front = surface([foot, head])
    flat = Shape(front.positions, front.triangles, front.normals, front.positions[:, :2] * (1, -1))
    soffit = surface([foot * (1, 1, -1), foot], 25.0)
    return join([flat, flat.turned(180), soffit])


def _arc(radius: float, count: int = 29) -> tuple[Doubles, Doubles]:
    """A semicircle (x, y) from right to left over the origin."""
    angle = np.linspace(0.0, pi, count)
    return radius * np.cos(angle), radius * np.sin(angle)


def archivolt(radius: float, width: float, depth: float) -> Shape:
    """The moulding on the face of an arch, to be laid on a wall at z = 0, facing +Z."""
    x, y = _arc(radius)
    section = [(-width, -0.01), (-width, depth * 0.7), (-width * 0.85, depth), (-width * 0.75, depth * 0.6)]
    section += [(-width * 0.4, depth * 0.55), (-width * 0.35, depth * 0.4), (0.006, depth * 0.35), (0.006, -0.01)]
    return moulding(section, np.stack([x, -y], axis=1), closed=False).turned(90, "x")


def keystone(height: float) -> Shape:
    """A wedge, its middle at the origin, that stands out from the face of an arch."""
    plain = box((0.2, height, 0.12), 0.012)
    taper = 1.0 + 0.22 * plain.positions[:, 1] / height
    positions = plain.positions * np.stack([taper, np.ones_like(taper), np.ones_like(taper)], axis=1)
    return Shape(positions, plain.triangles, plain.normals, plain.uvs)


def trunk(radius: float, low: float, high: float) -> Shape:
    """A slender stem from `low` to `high`."""
    return lathe([(radius, low), (radius * 0.8, low + 0.5 * (high - low)), (radius * 0.75, high)], 16)


def baluster(height: float) -> Shape:
    """A turned baluster on the origin."""
    t = np.linspace(0.0, 1.0, 10)
    belly = 0.036 + 0.034 * np.sin(pi * np.clip(t * 1.5, 0, 1)) ** 1.3 - 0.006 * t
    profile = [(0.07, 0.0), (0.07, 0.05), (0.05, 0.06)]
    profile += list(zip(belly.tolist(), (0.07 + (height - 0.14) * t).tolist(), strict=True))
    return lathe([*profile, (0.05, height - 0.06), (0.07, height - 0.05), (0.07, height)], 14)


def fountain(radius: float) -> tuple[Shape, Shape]:
    """An octagonal basin with a bowl on a pedestal in it, on the origin: (stone, water)."""
    angle = 2 * pi * (np.arange(8) + 0.5) / 8
    octagon = radius * np.stack([np.cos(angle), -np.sin(angle)], axis=1)
    section = [(-0.03, -0.01), (-0.03, 0.06), (0.0, 0.09), (0.03, 0.1), (0.03, 0.34), (0.0, 0.38), (-0.04, 0.4)]
    section += [(-0.045, 0.45), (-0.035, 0.46), (0.235, 0.46), (0.245, 0.45), (0.245, 0.42), (0.2, 0.38), (0.2, -0.01)]
    wall = moulding(section, octagon)
    bowl = [
        (0, 0.0),
        (0.24, 0.0),
        (0.24, 0.06),
        (0.17, 0.1),
        (0.1, 0.2),
        (0.085, 0.4),
        (0.11, 0.62),
        (0.15, 0.68),
        (0.1, 0.72),
    ]
    flare = np.linspace(0.0, 1.0, 14)
    bowl += [(0.1 + 0.5 * a**0.65, 0.74 + 0.2 * a**1.8) for a in flare]
    bowl += [(0.615, 0.95), (0.61, 0.965), (0.585, 0.965), (0.57, 0.95), (0.3, 0.86), (0.07, 0.84)]
    bowl += [(0.06, 0.95), (0.05, 1.1), (0.075, 1.2), (0.06, 1.24)]
    bowl += [(0.06 + 0.2 * a**0.65, 1.25 + 0.09 * a**1.8) for a in flare]
    bowl += [
        (0.265, 1.35),
        (0.25, 1.352),
        (0.12, 1.3),
        (0.04, 1.3),
        (0.05, 1.36),
        (0.075, 1.42),
        (0.05, 1.5),
        (0, 1.53),
    ]
    corner = (radius - 0.2 / np.cos(pi / 8) + 0.01) * np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], axis=1)
    ring = np.concatenate([corner, corner[:1]])
    basin = surface([np.zeros_like(ring), ring]).reversed().moved(y=0.33)
    pools = [lathe([(0, 0), (width, 0)], 48).reversed().moved(y=y) for width, y in ((0.568, 0.948), (0.2, 1.335))]
    return join([wall, lathe(bowl, 56)]), join([basin, *pools])


def urn(height: float) -> Shape:
    """An amphora-like urn on the origin."""
    t = np.linspace(0.0, 1.0, 21)
    belly = height * (0.1 + 0.2 * np.sin(pi * t**0.75) ** 1.2 * (1 - 0.3 * t))
    outer = list(zip(belly.tolist(), (height * (0.12 + 0.7 * t)).tolist(), strict=True))
    foot = [(0, 0.0), (0.17 * height, 0.0), (0.17 * height, 0.03 * height), (0.08 * height, 0.08 * height)]
    lip = [
        (0.1 * height, 0.9 * height),
        (0.18 * height, 0.97 * height),
        (0.18 * height, height),
        (0.15 * height, height),
    ]
    return lathe([*foot, *outer, *lip, (0.08 * height, 0.88 * height), (0, 0.86 * height)], 48)
