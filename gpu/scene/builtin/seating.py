"""Seats for living rooms. Each stands on the floor at the origin and faces +Z, in metres."""

import numpy as np

from gpu.scene.builtin.furnishings import cushion, tapered_leg
from gpu.scene.builtin.shape import Shape, copies, join, placed, rotation, warped
from gpu.scene.builtin.shapes import box, cylinder, lathe, rounded_path, slab, superellipse, tube


def sofa(width: float, seats: int, depth: float = 0.92) -> tuple[Shape, Shape]:
    """A sofa with `seats` loose seat and back cushions between its arms: (upholstery, legs)."""
    arm, floor = 0.19, 0.14
    inner = width - 2 * arm
    each = inner / seats
    base = box((width - 0.02, 0.2, depth - 0.04), 0.03, 2, 2).moved(0, floor + 0.1, 0)
    side = box((arm, 0.46, depth), 0.065, 4, 3).moved(width / 2 - arm / 2, floor + 0.232, 0)
    back = box((inner + 0.06, 0.62, 0.2), 0.07, 4, 3).moved(0, floor + 0.34, -depth / 2 + 0.102)
    seat = box((each - 0.006, 0.17, depth - 0.2), 0.05, 4, 8, 0.028)
    rest = box((each - 0.02, 0.15, 0.44), 0.06, 4, 8, 0.03).turned(74, "x")
    middles = (np.arange(seats) - (seats - 1) / 2) * each
    seats_at = [(x, floor + 0.272, 0.102) for x in middles]
    rests_at = [(x, floor + 0.56, -depth / 2 + 0.262) for x in middles]
    shapes = [base, side, side.mirrored(0), back, copies(seat, seats_at), copies(rest, rests_at)]
    leg = tapered_leg(floor + 0.02, 0.026, 0.016)
    feet = [(x * (width / 2 - 0.1), 0, z * (depth / 2 - 0.1)) for x in (-1, 1) for z in (-1, 1)]
    return join(shapes), placed(leg, feet)


def scatter(places: list[tuple[float, float, float]], degrees: list[float], size: float = 0.44) -> Shape:
    """Scatter cushions that lean back at `places` (the middle of each), turned in their own plane by `degrees`."""
    one = cushion(size, size, 0.13)
    lean = rotation(68, "x")
    return copies(one, places, [lean @ rotation(angle, "y") for angle in degrees])


def pouf(radius: float, height: float) -> Shape:
    """A ribbed pouf."""
    flat = lathe(_pillow_profile(radius, height), 96, 80.0)
    angle = np.arctan2(flat.positions[:, 2], flat.positions[:, 0])
    reach = np.hypot(flat.positions[:, 0], flat.positions[:, 2]) / radius
    ribs = 1.0 + 0.035 * (np.abs(np.sin(angle * 9.0)) ** 0.6 - 0.6) * np.clip(reach, 0.0, 1.0) ** 2
    return warped(flat, flat.positions * np.stack([ribs, np.ones_like(ribs), ribs], axis=1), 80.0)


def _pillow_profile(radius: float, height: float) -> list[tuple[float, float]]:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 25)
    x = radius * np.abs(np.cos(angle)) ** 0.45
    y = height / 2 * (1 + np.sign(angle) * np.abs(np.sin(angle)) ** 0.8) + 0.0005
    x[[0, -1]] = 0.0
    return list(zip(x.tolist(), y.tolist(), strict=True))


def wooden_chair() -> tuple[Shape, Shape]:
    """A dining chair with splayed legs, spindles and a bent top rail: (wood, seat pad)."""
    seat = slab(superellipse(0.225, 0.215, 3.2, 64), 0.03, 0.012, 3).moved(0, 0.425, 0)
    pad = slab(superellipse(0.195, 0.185, 3.0, 64), 0.028, 0.013, 3).moved(0, 0.4555, 0)
    legs = [
        tube([(sx * 0.2, 0.004, sz * 0.2), (sx * 0.185, 0.12, sz * 0.185), (sx * 0.145, 0.43, sz * 0.145)],
             [0.011, 0.014, 0.017], 16)
        for sx in (-1, 1) for sz in (-1, 1)
    ]  # fmt: skip
    rungs = [tube([(sx * 0.178, 0.19, -0.178), (sx * 0.178, 0.19, 0.178)], [0.009, 0.009], 12) for sx in (-1, 1)]
    rungs.append(tube([(-0.178, 0.19, 0.0), (0.178, 0.19, 0.0)], 0.009, 12))
    bend = np.linspace(-1.0, 1.0, 17)
    rail = np.stack([0.215 * bend, 0.8 + 0.03 * (1 - bend**2), -0.31 + 0.06 * bend**2], axis=1)
    top = tube(rail, 0.017 - 0.003 * bend**2, 16)
    ends = [[np.interp(x, rail[:, 0], rail[:, axis]) for axis in range(3)] for x in np.linspace(-0.2, 0.2, 6)]
    spindles = [tube([(0.75 * end[0], 0.44, -0.165 + 0.75 * end[0] ** 2), end], 0.0075, 12) for end in ends]
    return join([seat, *legs, *rungs, top, *spindles]), pad


def stool_table(radius: float, height: float, thick: float = 0.03) -> tuple[Shape, Shape]:
    """A round table on three splayed legs: (top, legs)."""
    top = slab(superellipse(radius, radius, 2.0, 96), thick, 0.01, 3).moved(0, height - thick, 0)
    leg = tube([(0.0, 0.004, radius * 0.8), (0.0, height - thick + 0.004, radius * 0.52)], [0.013, 0.02], 18)
    return top, join([leg.turned(angle) for angle in (20, 140, 260)])


def floor_lamp(height: float) -> Shape:
    """The foot and pole of a floor lamp, up to `height`."""
    foot = cylinder(0.15, 0.018, 48, 0.006).moved(0, 0.0005, 0)
    return join([foot, cylinder(0.011, height - 0.01, 20).moved(0, 0.01, 0)])


def pendant(drop: float) -> tuple[Shape, Shape]:
    """A dome lamp that hangs `drop` below the origin: (dome and flex, inside of the dome)."""
    angle = np.linspace(0.0, np.pi / 2, 16)
    outer = [(0.22 * np.cos(a), -drop + 0.2 * np.sin(a)) for a in angle[:-1]] + [
        (0.02, -drop + 0.2),
        (0.016, -drop + 0.25),
    ]
    inner = [(r - 0.002, y - 0.001) for r, y in reversed(outer[:-2])]
    flex = tube(rounded_path([(0, -drop + 0.24, 0), (0, 0.002, 0)], 0.0), 0.003, 8)
    rose = lathe([(0, -0.025), (0.04, -0.022), (0.045, 0.001)], 32)
    return join([lathe([*outer, (0, -drop + 0.255)], 48), flex, rose]), lathe(
        [(0, -drop + 0.197), *inner, outer[0]], 48
    )
