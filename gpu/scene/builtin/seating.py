"""Seats and tables of living rooms. Each stands on the floor at the origin and faces +Z, in metres."""

from math import pi

import numpy as np

from gpu.scene.builtin.furnishings import cushion
from gpu.scene.builtin.shape import Shape, join, rotation, warped
from gpu.scene.builtin.shapes import box, lathe, slab, superellipse, tube

Place = tuple[float, float, float]


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
    xs = (np.arange(seats) - (seats - 1) / 2) * each
    seating = seat.at([(x, floor + 0.272, 0.102) for x in xs])
    resting = rest.at([(x, floor + 0.56, -depth / 2 + 0.262) for x in xs])
    feet = [(x * (width / 2 - 0.1), 0, z * (depth / 2 - 0.1)) for x in (-1, 1) for z in (-1, 1)]
    legs = tapered_leg(floor + 0.02, 0.026, 0.016).at(feet)
    return join([base, side, side.mirrored(0), back, seating, resting]), legs


def tapered_leg(height: float, top: float, foot: float) -> Shape:
    """A round wooden leg from the floor up."""
    return lathe([(0, 0.0005), (foot - 0.002, 0.0005), (foot, 0.003), (top, height), (0, height)], 20)


def scatter(place: Place, degrees: float, size: float = 0.44) -> Shape:
    """A scatter cushion that leans back, its middle at `place`, turned in its own plane by `degrees`."""
    return cushion(size).copies(place, (rotation(68, "x") @ rotation(degrees))[None])


def pouf(radius: float, height: float) -> Shape:
    """A ribbed pouf."""
    angle = np.linspace(-pi / 2, pi / 2, 25)
    x = radius * np.abs(np.cos(angle)) ** 0.45
    y = height / 2 * (1 + np.sign(angle) * np.abs(np.sin(angle)) ** 0.8) + 0.0005
    x[[0, -1]] = 0.0
    flat = lathe(np.stack([x, y], axis=1), 96, 80.0)
    turn = np.arctan2(flat.positions[:, 2], flat.positions[:, 0])
    reach = np.hypot(flat.positions[:, 0], flat.positions[:, 2]) / radius
    ribs = 1.0 + 0.035 * (np.abs(np.sin(turn * 9.0)) ** 0.6 - 0.6) * np.clip(reach, 0.0, 1.0) ** 2
    return warped(flat, flat.positions * np.stack([ribs, np.ones_like(ribs), ribs], axis=1), 80.0)


def wooden_chair() -> tuple[Shape, Shape]:
    """A dining chair with splayed legs, spindles and a bent top rail: (wood, seat pad)."""
    seat = slab(superellipse(0.225, 0.215, 3.2), 0.03, 0.012, 3).moved(0, 0.425, 0)
    pad = slab(superellipse(0.195, 0.185, 3.0), 0.028, 0.013, 3).moved(0, 0.4555, 0)
    legs = [
        tube([(x * s, y, z * s) for s, y in ((0.2, 0.004), (0.185, 0.12), (0.145, 0.43))], [0.011, 0.014, 0.017], 16)
        for x in (-1, 1)
        for z in (-1, 1)
    ]
    rungs = [tube([(x * 0.178, 0.19, -0.178), (x * 0.178, 0.19, 0.178)], 0.009, 12) for x in (-1, 1)]
    rungs.append(tube([(-0.178, 0.19, 0.0), (0.178, 0.19, 0.0)], 0.009, 12))
    bend = np.linspace(-1.0, 1.0, 17)
    rail = np.stack([0.215 * bend, 0.8 + 0.03 * (1 - bend**2), -0.31 + 0.06 * bend**2], axis=1)
    top = tube(rail, 0.017 - 0.003 * bend**2, 16)
    ends = [[np.interp(x, rail[:, 0], line) for line in rail.T] for x in np.linspace(-0.2, 0.2, 6)]
    spindles = [tube([(0.75 * end[0], 0.44, -0.165 + 0.75 * end[0] ** 2), end], 0.0075, 12) for end in ends]
    return join([seat, *legs, *rungs, top, *spindles]), pad


def stool_table(radius: float, height: float, thick: float) -> tuple[Shape, Shape]:
    """A round table on three splayed legs: (top, legs)."""
    top = slab(superellipse(radius, radius, 2.0, 96), thick, 0.01, 3).moved(0, height - thick, 0)
    leg = tube([(0.0, 0.004, radius * 0.8), (0.0, height - thick + 0.004, radius * 0.52)], [0.013, 0.02], 18)
    return top, join([leg.turned(angle) for angle in (20, 140, 260)])
