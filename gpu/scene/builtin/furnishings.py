"""Small things that make a room lived in: plants, bowls, mugs, books, lamps. Each stands on the origin, in metres."""

from collections.abc import Iterable
from dataclasses import replace
from math import pi

import numpy as np

from gpu.scene.builtin.shape import Shape, join, rotation, warped
from gpu.scene.builtin.shapes import Points, block, box, cylinder, lathe, points, sphere, surface, tube
from gpu.scene.types import Doubles


def leaf(length: float, width: float, droop: float, across: int = 5, along: int = 9) -> Shape:
    """A leaf that begins at the origin, grows along +Z and bends down by `droop` times its length; v runs along it."""
    t, s = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(-1.0, 1.0, across), indexing="ij")
    half = 0.5 * width * np.maximum(np.sin(pi * t**0.8), 0.02) ** 0.8
    y = 0.12 * width * np.abs(s) * np.sin(pi * t) - droop * length * t**2
    shape = surface(np.stack([-s * half, y, length * t], axis=-1), 80.0)
    return replace(shape, uvs=shape.positions[:, [0, 2]] / (-width, length) + (0.5, 0.0))


def aim(yaw: Iterable[float], pitch: Iterable[float], roll: Iterable[float]) -> Doubles:
    """Matrices (copy, 3, 3) that tip a shape up about X by `pitch`, after `roll` about Z, then turn it about Y."""
    turns = zip(yaw, pitch, roll, strict=True)
    return np.array([rotation(a, "y") @ rotation(-b, "x") @ rotation(c, "z") for a, b, c in turns])


def pot(radius: float, height: float) -> tuple[Shape, Shape]:
    """A round planter and the soil in it."""
    inside, a = radius - 0.018, np.linspace(0.0, 1.0, 7)
    profile = [(0, 0), (radius * 0.72, 0), (radius * 0.76, 0.006), (radius * 0.97, height * 0.86)]
    profile += [(radius, height - 0.006), (radius - 0.005, height), (inside, height - 0.004)]
    mound = zip(radius * 0.95 * (1 - a), height - 0.045 + 0.02 * a * (2 - a), strict=True)
    soil = lathe([(inside - 0.001, height - 0.045), *mound], 48)
    return lathe([*profile, (inside - 0.002, height * 0.8)], 48), soil


def tree(seed: int, height: float, leaf_count: int, base: float) -> tuple[Shape, Shape]:
    """A potted fig of five stems that grows from y = `base` up to `height`: (stems, leaves)."""
    rng, stems = np.random.default_rng(seed), 5
    t = np.linspace(0.0, 1.0, 14)
    paths = []
    for number in range(stems):
        out, turn = rng.uniform(0.08, 0.2), 2 * pi * number / stems + rng.normal(0.0, 0.3)
        top = height * rng.uniform(0.72, 0.96)
        wave = 0.03 * np.sin(t * rng.uniform(3, 6) + turn)
        x, z = (np.cos(turn) * (0.02 + out * t**1.5) + wave, np.sin(turn) * (0.02 + out * t**1.5) - wave)
        paths.append(np.stack([x, base - 0.03 + (top - base) * t, z], axis=1))
    which = rng.integers(0, stems, leaf_count)
    at = rng.uniform(0.32, 1.0, leaf_count) ** 0.8
    roots = np.array([[np.interp(a, t, line) for line in paths[n].T] for n, a in zip(which, at, strict=True)])
    yaw = (137.5 * np.arange(leaf_count) + rng.normal(0.0, 20.0, leaf_count)) % 360.0
    pitch = 5.0 + 45.0 * at + rng.normal(0.0, 12.0, leaf_count)
    # Stalks carry the leaves outwards and upwards.
    reach = rng.uniform(0.04, 0.14, leaf_count)[:, None]
    away = np.stack([np.sin(np.radians(yaw)), np.full(leaf_count, 0.5), np.cos(np.radians(yaw))], axis=1) * reach
    stalk = tube([(0, 0, 0), (0, 0, 1.0)], 0.0018, 5)
    none = np.zeros(leaf_count)
    lean = aim(yaw, none + np.degrees(np.arctan(0.5)), none)
    stalks = [
        replace(stalk, positions=stalk.positions * np.array([1, 1, np.linalg.norm(way)])).copies(root, matrix[None])
        for way, root, matrix in zip(away, roots, lean, strict=True)
    ]
    matrices = aim(yaw, pitch, rng.normal(0.0, 15.0, leaf_count)) * rng.uniform(0.75, 1.15, leaf_count)[:, None, None]
    foliage = leaf(0.2, 0.105, 0.35).copies(roots + away, matrices)
    normals = foliage.normals / np.linalg.norm(foliage.normals, axis=1)[:, None]
    return join([*(tube(path, 0.011 - 0.008 * t, 8) for path in paths), *stalks]), replace(foliage, normals=normals)


def mug(radius: float, height: float) -> Shape:
    """A mug with a handle towards +X."""
    wall = 0.004
    profile = [(0, 0.004), (radius * 0.7, 0.004), (radius * 0.76, 0), (radius * 0.9, 0.004), (radius, 0.02)]
    profile += [(radius, height - 0.002), (radius - wall / 2, height), (radius - wall, height - 0.002)]
    profile += [(radius - wall, 0.02), (radius * 0.7, 0.009), (0, 0.009)]
    arc = np.linspace(-pi / 2, pi / 2, 14)
    handle = np.stack([radius - 0.003 + 0.03 * np.cos(arc), height / 2 + 0.03 * np.sin(arc), 0 * arc], axis=1)
    return join([lathe(profile, 36), tube(handle, 0.0045, 10)])


def saucer(radius: float = 0.075) -> Shape:
    """A plate with a low rim."""
    profile = [(0, 0.002), (radius * 0.5, 0.002), (radius * 0.55, 0), (radius * 0.62, 0.003), (radius, 0.014)]
    return lathe([*profile, (radius - 0.001, 0.017), (radius * 0.6, 0.008), (0, 0.006)], 40)


def bowl_of_fruit(seed: int) -> tuple[Shape, Shape, Shape]:
    """A bowl with two kinds of fruit: (bowl, oranges, apples)."""
    outer = [(0.055 + 0.115 * a**0.7, 0.012 + 0.085 * a**1.6) for a in np.linspace(0.0, 1.0, 12)]
    inner = [(x - 0.006, y + 0.002) for x, y in reversed(outer)]
    bowl = lathe([(0, 0.004), (0.045, 0.004), (0.05, 0), *outer, *inner, (0, 0.016)], 48)
    rng = np.random.default_rng(seed)
    places: Points = [(0.085 * np.cos(a), 0.062, 0.085 * np.sin(a)) for a in 2 * pi * np.arange(6) / 6 + 0.2]
    places += points("0,.055,0 .045,.118,.01 -.03,.116,.035 -.012,.115,-.045")
    turns = aim(rng.uniform(0, 360, 10), rng.uniform(-30, 30, 10), np.zeros(10))
    angle = np.linspace(-pi / 2, pi / 2, 15)
    dimple = 1.0 - 0.28 * np.exp(-((angle - pi / 2) ** 2) * 6) - 0.1 * np.exp(-((angle + pi / 2) ** 2) * 8)
    profile = np.stack([0.038 * np.cos(angle), 0.036 * np.sin(angle) * dimple], axis=1)
    profile[[0, -1], 0] = 0.0
    apples, spots = np.arange(10) % 3 == 1, np.array(places)
    orange, apple = sphere(0.037, 28), lathe(profile, 28, 60.0)
    return bowl, orange.copies(spots[~apples], turns[~apples]), apple.copies(spots[apples], turns[apples])


def vase(radius: float, height: float) -> Shape:
    """A bellied vase with a narrow neck."""
    t = np.linspace(0.0, 1.0, 25)
    swell = 0.45 * np.sin(pi * np.minimum(t * 1.25, 1.0) ** 0.9)
    belly = radius * (0.55 + swell - 0.28 * np.clip(t * 1.6 - 0.8, 0, 1) ** 0.7)
    outer = list(zip(belly, 0.002 + t * height, strict=True))
    inner = [(r - 0.005, y) for r, y in reversed(outer[8:])]
    return lathe([(0, 0.004), (belly[0] * 0.9, 0), *outer, *inner, (0, inner[-1][1])], 44)


def laptop() -> tuple[Shape, Shape]:
    """An open laptop that faces +Z: (case, keys and screen)."""
    base = box((0.32, 0.014, 0.22), 0.004, 2).moved(0, 0.008, 0)
    lid = box((0.32, 0.212, 0.008), 0.0035, 2).moved(0, 0.108, 0).turned(-18, "x").moved(0, 0.013, -0.108)
    grid = [(x, 0.0158, z) for z in np.arange(5) * 0.0185 - 0.08 for x in (np.arange(14) - 6.5) * 0.0195]
    pad = box((0.1, 0.002, 0.06), 0.0008).moved(0, 0.0152, 0.065)
    screen = box((0.3, 0.19, 0.002), 0.0008).moved(0, 0.11, 0.0042).turned(-18, "x").moved(0, 0.013, -0.108)
    return join([base, lid, pad]), join([box((0.0155, 0.003, 0.0155), 0.001).at(grid), screen])


def books(seed: int, length: float, height: float) -> tuple[Shape, Shape]:
    """A row of books along +X from the origin, spines towards +Z at z = 0: (covers, pages).

    height: of the tallest; the covers' UVs lie in one of 32 columns of a texture of spines.
    """
    rng = np.random.default_rng(seed)
    covers, pages, x, board = [], [], 0.0, 0.003
    while x + (thick := rng.uniform(0.016, 0.042)) <= length:
        tall, deep = height * rng.uniform(0.72, 1.0), 0.22 * rng.uniform(0.75, 1.0)
        back, end = -rng.uniform(0.0, 0.012), x + thick
        left = block((x, 0, back - deep), (x + board, tall, back))
        right = block((end - board, 0, back - deep), (end, tall, back))
        spine = block((x + board, 0, back - board), (end - board, tall, back))
        column = int(rng.integers(0, 32))
        for piece in (left, right, spine):
            u = (column + np.clip((piece.positions[:, 0] - x) / thick, 0.08, 0.92)) / 32
            covers.append(replace(piece, uvs=np.stack([u, 0.99 - 0.98 * piece.positions[:, 1] / tall], axis=1)))
        pages.append(block((x + board, 0.004, back - deep + 0.004), (end - board, tall - 0.004, back - board)))
        x += thick + 0.0006
    return join(covers), join(pages)


def cushion(size: float) -> Shape:
    """A square scatter cushion, lying flat with its middle at the origin: plump in the middle, its corners pinched."""
    flat = box((size, 0.13, size), 0.13 * 0.3, 2, 10)
    x, z = flat.positions[:, 0] / (size / 2), flat.positions[:, 2] / (size / 2)
    plump = 0.18 + 1.15 * np.sqrt(np.clip((1 - x**2) * (1 - z**2), 0.0, 1.0)) ** 0.8
    pinch = 1.0 - 0.07 * (1 - np.abs(np.stack([z, x], axis=1)) ** 2)
    return warped(flat, flat.positions * np.stack([pinch[:, 0], plump, pinch[:, 1]], axis=1), 75.0)


def drum_shade(radius: float, height: float, taper: float = 0.85) -> tuple[Shape, Shape]:
    """A lamp shade from y = 0 up, open above and below: (outside, lining)."""
    inside, top = radius - 0.003, radius * taper
    lining = [(top - 0.003, height), (inside, 0)]
    return lathe([lining[1], (radius, 0), (top, height), lining[0]], 48), lathe(lining, 48)


def pendant(drop: float) -> tuple[Shape, Shape]:
    """A dome lamp that hangs `drop` below the origin: (dome and flex, inside of the dome)."""
    outer: Points = [(0.22 * np.cos(a), -drop + 0.2 * np.sin(a)) for a in np.linspace(0.0, pi / 2, 16)[:-1]]
    inner = [(r - 0.002, y - 0.001) for r, y in reversed(outer)]
    dome = lathe([*outer, (0.02, -drop + 0.2), (0.016, -drop + 0.25), (0, -drop + 0.255)], 48)
    flex = tube([(0, -drop + 0.24, 0), (0, 0.002, 0)], 0.003, 8)
    rose = lathe(points("0,-.025 .04,-.022 .045,.001"), 32)
    return join([dome, flex, rose]), lathe([(0, -drop + 0.197), *inner, outer[0]], 48)


def curtain(width: float, height: float, folds: float, depth: float, seed: int) -> Shape:
    """A hanging curtain from the floor up, in folds of ± `depth` about z = 0, centred on the origin, facing +Z."""
    s, t = np.linspace(0.0, 1.0, int(folds * 16)), np.linspace(0.0, 1.0, 14)[:, None]
    phase = 2 * pi * folds * s + np.cumsum(np.random.default_rng(seed).normal(0.0, 0.08, len(s)))
    z = depth * (np.sin(phase) + 0.2 * np.sin(2.3 * phase + 1.0)) * (1.0 - 0.35 * t)
    x = (s - 0.5) * width * (1.0 - 0.03 * np.sin(pi * t) ** 2)
    return surface(np.stack([x, np.broadcast_to(0.015 + (height - 0.015) * t, z.shape), z], axis=-1), 90.0)


def rod(length: float) -> Shape:
    """A curtain rod along X with round ends, its middle at the origin."""
    bar = tube([(-length / 2, 0, 0), (length / 2, 0, 0)], 0.012, 16)
    return join([bar, *(sphere(0.024, 20).moved(side * length / 2) for side in (-1, 1))])


def clock(radius: float) -> tuple[Shape, Shape, Shape]:
    """A wall clock on a wall at z = 0, facing +Z: (rim, face, marks and hands)."""
    inner = radius - 0.014
    rim = [(inner, 0.001), (radius, 0.001), (radius, 0.03), (radius - 0.006, 0.036), (inner, 0.03), (inner, 0.001)]
    mark = block((-0.004, 0.0165, radius * 0.72), (0.004, 0.0185, radius * 0.84))
    hour = block((-0.006, 0.0195, -0.03), (0.006, 0.0215, radius * 0.48)).turned(118.0)
    minute = block((-0.004, 0.0225, -0.03), (0.004, 0.0245, radius * 0.7)).turned(-130.0)
    marks = join([mark.at(np.zeros((12, 3)), 30.0 * np.arange(12)), hour, minute])
    face = cylinder(radius - 0.013, 0.016, 64)
    return lathe(rim, 64).turned(90, "x"), face.turned(90, "x"), marks.turned(90, "x")
