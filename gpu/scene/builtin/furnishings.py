"""Small things that make a room lived in: plants, bowls, mugs, books, lamps. Each stands on the origin, in metres."""

from math import pi

import numpy as np

from gpu.scene.builtin.shape import Shape, copies, join, rotation, warped
from gpu.scene.builtin.shapes import block, box, cylinder, lathe, rounded_path, sphere, surface, tube
from gpu.scene.types import Doubles


def leaf(length: float, width: float, droop: float, across: int = 5, along: int = 9) -> Shape:
    """A leaf that begins at the origin, grows along +Z and bends down by `droop` times its length; v runs along it."""
    t, s = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(-1.0, 1.0, across), indexing="ij")
    half = 0.5 * width * np.maximum(np.sin(pi * t**0.8), 0.02) ** 0.8
    y = 0.12 * width * np.abs(s) * np.sin(pi * t) - droop * length * t**2
    points = np.stack([-s * half, y, length * t], axis=-1)
    shape = surface(points, 80.0)
    flat = np.stack([0.5 - shape.positions[:, 0] / width, shape.positions[:, 2] / length], axis=1)
    return Shape(shape.positions, shape.triangles, shape.normals, flat)


def _aim(yaw: Doubles, pitch: Doubles, roll: Doubles) -> Doubles:
    """Matrices (copy, 3, 3) that tip a shape up about X by `pitch`, after `roll` about Z, then turn it about Y."""
    turns = zip(yaw, pitch, roll, strict=True)
    return np.array([rotation(a, "y") @ rotation(-b, "x") @ rotation(c, "z") for a, b, c in turns])


def pot(radius: float, height: float) -> tuple[Shape, Shape]:
    """A round planter and the soil in it."""
    wall = 0.018
    profile = [
        (0, 0),
        (radius * 0.72, 0),
        (radius * 0.76, 0.006),
        (radius * 0.97, height * 0.86),
        (radius, height - 0.006),
    ]
    profile += [(radius - 0.005, height), (radius - wall, height - 0.004), (radius - wall - 0.002, height * 0.8)]
    angle = np.linspace(0.0, 1.0, 7)
    soil = [
        (radius - wall - 0.001, height - 0.045),
        *((radius * 0.95 * (1 - a), height - 0.045 + 0.02 * a * (2 - a)) for a in angle),
    ]
    return lathe(profile, 48), lathe(soil, 48)


def tree(seed: int, height: float, stems: int, leaf_count: int, base: float) -> tuple[Shape, Shape]:
    """A potted fig that grows from y = `base` up to `height`: (stems, leaves)."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, 14)
    paths, roots = [], []
    for number in range(stems):
        out, turn = rng.uniform(0.08, 0.2), 2 * pi * number / stems + rng.normal(0.0, 0.3)
        top = height * rng.uniform(0.72, 0.96)
        wave = 0.03 * np.sin(t * rng.uniform(3, 6) + turn)
        x, z = (np.cos(turn) * (0.02 + out * t**1.5) + wave, np.sin(turn) * (0.02 + out * t**1.5) - wave)
        paths.append(np.stack([x, base - 0.03 + (top - base) * t, z], axis=1))
        roots.append(top)
    wood = join([tube(path, 0.011 - 0.008 * t, 8) for path in paths])
    which = rng.integers(0, stems, leaf_count)
    at = rng.uniform(0.32, 1.0, leaf_count) ** 0.8
    points = np.stack(
        [[np.interp(a, t, paths[n][:, axis]) for axis in range(3)] for n, a in zip(which, at, strict=True)]
    )
    yaw = (137.5 * np.arange(leaf_count) + rng.normal(0.0, 20.0, leaf_count)) % 360.0
    pitch = 5.0 + 45.0 * at + rng.normal(0.0, 12.0, leaf_count)
    # Stalks carry the leaves outwards and upwards.
    reach = rng.uniform(0.04, 0.14, leaf_count)
    away = (
        np.stack([np.sin(np.radians(yaw)), np.full(leaf_count, 0.5), np.cos(np.radians(yaw))], axis=1) * reach[:, None]
    )
    stalk = tube([(0, 0, 0), (0, 0, 1.0)], 0.0018, 5)
    length = np.linalg.norm(away, axis=1)
    stalks = [Shape(stalk.positions * (1, 1, size), stalk.triangles, stalk.normals, stalk.uvs) for size in length]
    lean = _aim(yaw, np.full(leaf_count, np.degrees(np.arctan(0.5))), np.zeros(leaf_count))
    wood = join([wood, *(copies(one, [p], [m]) for one, p, m in zip(stalks, points, lean, strict=True))])
    matrices = _aim(yaw, pitch, rng.normal(0.0, 15.0, leaf_count)) * rng.uniform(0.75, 1.15, leaf_count)[:, None, None]
    foliage = copies(leaf(0.2, 0.105, 0.35), points + away, matrices)
    normals = foliage.normals / np.linalg.norm(foliage.normals, axis=1)[:, None]
    return wood, Shape(foliage.positions, foliage.triangles, normals, foliage.uvs)


def topiary(seed: int, radius: float, leaf_count: int) -> tuple[Shape, Shape]:
    """A clipped ball of leaves about the origin, and the darkness within it: (leaves, core)."""
    rng = np.random.default_rng(seed)
    out = rng.standard_normal((leaf_count, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    yaw = np.degrees(np.arctan2(out[:, 0], out[:, 2])) + rng.normal(0.0, 40.0, leaf_count)
    pitch = np.degrees(np.arcsin(out[:, 1])) + rng.normal(0.0, 30.0, leaf_count)
    matrices = _aim(yaw, pitch, rng.uniform(-60.0, 60.0, leaf_count))
    places = out * radius * rng.uniform(0.86, 0.97, leaf_count)[:, None]
    return copies(leaf(radius * 0.22, radius * 0.13, 0.2, 3, 5), places, matrices), sphere(radius * 0.88, 40)


def mug(radius: float = 0.04, height: float = 0.095) -> Shape:
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
    t = np.linspace(0.0, 1.0, 12)
    outer = [(0.055 + 0.115 * a**0.7, 0.012 + 0.085 * a**1.6) for a in t]
    inner = [(x - 0.006, y + 0.002) for x, y in reversed(outer)]
    bowl = lathe([(0, 0.004), (0.045, 0.004), (0.05, 0), *outer, *inner, (0, 0.016)], 48)
    rng = np.random.default_rng(seed)
    places = [(0.085 * np.cos(a), 0.062, 0.085 * np.sin(a)) for a in 2 * pi * np.arange(6) / 6 + 0.2]
    places += [(0.0, 0.055, 0.0), (0.045, 0.118, 0.01), (-0.03, 0.116, 0.035), (-0.012, 0.115, -0.045)]
    turns = _aim(rng.uniform(0, 360, 10), rng.uniform(-30, 30, 10), np.zeros(10))
    angle = np.linspace(-pi / 2, pi / 2, 15)
    dimple = 1.0 - 0.28 * np.exp(-((angle - pi / 2) ** 2) * 6) - 0.1 * np.exp(-((angle + pi / 2) ** 2) * 8)
    profile = np.stack([0.038 * np.cos(angle), 0.036 * np.sin(angle) * dimple], axis=1)
    profile[[0, -1], 0] = 0.0
    apple, orange = lathe(profile.tolist(), 28, 60.0), sphere(0.037, 28)
    kinds = np.arange(10) % 3 == 1
    spots = np.array(places)
    return bowl, copies(orange, spots[~kinds], turns[~kinds]), copies(apple, spots[kinds], turns[kinds])


def vase(radius: float, height: float) -> Shape:
    """A bellied vase with a narrow neck."""
    t = np.linspace(0.0, 1.0, 25)
    belly = radius * (
        0.55 + 0.45 * np.sin(pi * np.minimum(t * 1.25, 1.0) ** 0.9) - 0.28 * np.clip(t * 1.6 - 0.8, 0, 1) ** 0.7
    )
    outer = list(zip(belly.tolist(), (0.002 + t * height).tolist(), strict=True))
    inner = [(r - 0.005, y) for r, y in reversed(outer[8:])]
    return lathe([(0, 0.004), (belly[0] * 0.9, 0), *outer, *inner, (0, inner[-1][1])], 44)


def laptop() -> tuple[Shape, Shape]:
    """An open laptop that faces +Z: (case, keys and screen)."""
    base = box((0.32, 0.014, 0.22), 0.004, 2).moved(0, 0.008, 0)
    lid = box((0.32, 0.212, 0.008), 0.0035, 2).moved(0, 0.108, 0).turned(-18, "x").moved(0, 0.013, -0.108)
    key = box((0.0155, 0.003, 0.0155), 0.001)
    grid = [(x, 0.0158, z) for z in np.arange(5) * 0.0185 - 0.08 for x in (np.arange(14) - 6.5) * 0.0195]
    pad = box((0.1, 0.002, 0.06), 0.0008).moved(0, 0.0152, 0.065)
    screen = box((0.3, 0.19, 0.002), 0.0008).moved(0, 0.11, 0.0042).turned(-18, "x").moved(0, 0.013, -0.108)
    return join([base, lid, pad]), join([copies(key, grid), screen])


def books(seed: int, length: float, height: float, depth: float, atlas: int = 32) -> tuple[Shape, Shape]:
    """A row of books along +X from the origin, spines towards +Z at z = 0: (covers, pages).

    height, depth: of the largest; the covers' UVs lie in one of `atlas` columns of a texture of spines.
    """
    rng = np.random.default_rng(seed)
    covers, pages, x = [], [], 0.0
    board = 0.003
    while True:
        thick = rng.uniform(0.016, 0.042)
        if x + thick > length:
            break
        tall, deep = height * rng.uniform(0.72, 1.0), depth * rng.uniform(0.75, 1.0)
        back = -rng.uniform(0.0, 0.012)
        column = int(rng.integers(0, atlas))
        for low, high in (
            ((x, 0, back - deep), (x + board, tall, back)),
            ((x + thick - board, 0, back - deep), (x + thick, tall, back)),
            ((x + board, 0, back - board), (x + thick - board, tall, back)),
        ):
            piece = block(low, high)
            u = (column + np.clip((piece.positions[:, 0] - x) / thick, 0.08, 0.92)) / atlas
            v = 0.99 - 0.98 * piece.positions[:, 1] / tall
            covers.append(Shape(piece.positions, piece.triangles, piece.normals, np.stack([u, v], axis=1)))
        pages.append(block((x + board, 0.004, back - deep + 0.004), (x + thick - board, tall - 0.004, back - board)))
        x += thick + 0.0006
    return join(covers), join(pages)


def cushion(width: float, height: float, thick: float) -> Shape:
    """A scatter cushion, lying flat with its middle at the origin: plump in the middle, pinched at its corners."""
    flat = box((width, thick, height), thick * 0.3, 2, 10)
    x, z = flat.positions[:, 0] / (width / 2), flat.positions[:, 2] / (height / 2)
    plump = 0.18 + 1.15 * np.sqrt(np.clip((1 - x**2) * (1 - z**2), 0.0, 1.0)) ** 0.8
    pinch = 1.0 - 0.07 * (1 - np.abs(np.stack([z, x], axis=1)) ** 2)
    points = flat.positions * np.stack([pinch[:, 0], plump, pinch[:, 1]], axis=1)
    return warped(flat, points, 75.0)


def drum_shade(radius: float, height: float, taper: float = 0.85) -> tuple[Shape, Shape]:
    """A lamp shade from y = 0 up, open above and below: (outside, lining)."""
    wall = 0.003
    top = radius * taper
    outside = lathe([(radius - wall, 0), (radius, 0), (top, height), (top - wall, height)], 48)
    return outside, lathe([(top - wall, height), (radius - wall, 0)], 48)


def tapered_leg(height: float, top: float, foot: float) -> Shape:
    """A round wooden leg from the floor up."""
    return lathe([(0, 0.0005), (foot - 0.002, 0.0005), (foot, 0.003), (top, height), (0, height)], 20)


def curtain(width: float, height: float, folds: float, depth: float, seed: int, gather: float = 0.25) -> Shape:
    """A hanging curtain from the floor up, in folds of ± `depth` about z = 0, centred on the origin, facing +Z."""
    rng = np.random.default_rng(seed)
    s = np.linspace(0.0, 1.0, int(folds * 16))
    t = np.linspace(0.0, 1.0, 14)
    phase = 2 * pi * folds * s + np.cumsum(rng.normal(0.0, 0.08, len(s)))
    wave = np.sin(phase) + 0.2 * np.sin(2.3 * phase + 1.0)
    spread = 1.0 - gather * 0.12 * np.sin(pi * t) ** 2
    x = (s - 0.5)[None] * width * spread[:, None]
    z = depth * wave[None] * (1.0 - 0.35 * t[:, None])
    y = np.broadcast_to(0.015 + (height - 0.015) * t[:, None], z.shape)
    return surface(np.stack([x, y, z], axis=-1), 90.0)


def rod(length: float, radius: float = 0.012) -> Shape:
    """A curtain rod along X with round ends, its middle at the origin."""
    bar = tube(rounded_path([(-length / 2, 0, 0), (length / 2, 0, 0)], 0.0), radius, 16)
    return join([bar, *(sphere(radius * 2.0, 20).moved(side * length / 2) for side in (-1, 1))])


def clock(radius: float) -> tuple[Shape, Shape, Shape]:
    """A wall clock on a wall at z = 0, facing +Z: (rim, face, marks and hands)."""
    rim = lathe(
        [
            (radius - 0.014, 0.001),
            (radius, 0.001),
            (radius, 0.03),
            (radius - 0.006, 0.036),
            (radius - 0.014, 0.03),
            (radius - 0.014, 0.001),
        ],
        64,
    )
    face = cylinder(radius - 0.013, 0.016, 64)
    mark = block((-0.004, 0.0165, radius * 0.72), (0.004, 0.0185, radius * 0.84))
    marks = copies(mark, np.zeros((12, 3)), [rotation(30.0 * hour, "y") for hour in range(12)])
    hands = [
        block((-w, low, -0.03), (w, low + 0.002, length)).turned(angle)
        for angle, length, w, low in ((118.0, radius * 0.48, 0.006, 0.0195), (-130.0, radius * 0.7, 0.004, 0.0225))
    ]
    return rim.turned(90, "x"), face.turned(90, "x"), join([marks, *hands]).turned(90, "x")
