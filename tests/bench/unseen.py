"""Rooms like those that others publish, made for `elsewhere` and for nothing else: nobody tunes for them.

Each has what is hard: light by one bright patch, by a gap, or from behind a shade; thin legs, books and grout; gloss.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import cos, radians, sin

import numpy as np

from gpu.scene.builtin import furnishings, rooms, seating
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.furnishings import books, curtain, drum_shade, mug, pendant, saucer, vase
from gpu.scene.builtin.rooms import Opening
from gpu.scene.builtin.shape import join
from gpu.scene.builtin.shapes import block, box, cylinder, lathe, moulding, points, quad, rectangle, sphere, tube
from gpu.scene.camera import look_at
from gpu.scene.lighting.daylight import daylight
from gpu.scene.types import Environment, Light, LightKind, Material, Scene

CORNICE = points("-.002,-.11 -.002,.002 .1,.002 .1,-.012 .082,-.02 .06,-.034 .042,-.054 .03,-.08 .012,-.095 .012,-.11")
PAINTS = (
    "white #e8e4da 0.9, grey #8d8f92 0.8, green #3f5a4a 0.9, wood #9c6f45 0.35, dark #3a2c22 0.3, red #a03428 0.6, "
    "blue #31486b 0.7, tile #dfe3e2 0.15, grout #77756f 0.95, cloth #b9ae9c 1.0, black #1c1c1e 0.4, soil #7d705c 1.0, "
    "china #e6e0d4 0.2, lino #7a8a86 0.3"
)


def _builder(name: str) -> Builder:
    builder = Builder(name)
    builder.paints(PAINTS)
    metals = {"steel": (0.56, 0.57, 0.58, 0.35), "chrome": (0.6, 0.6, 0.6, 0.08), "brass": (0.7, 0.5, 0.25, 0.25)}
    for metal, (red, green, blue, roughness) in metals.items():
        builder.material(Material(metal, base_color=(red, green, blue, 1.0), metallic=1.0, roughness=roughness))
    builder.material(Material("mirror", base_color=(0.9, 0.9, 0.9, 1.0), metallic=1.0, roughness=0.0))
    builder.material(Material("pane", transmission=1.0, roughness=0.0))
    builder.material(Material("body", transmission=1.0, roughness=0.0, thickness=0.05))
    builder.material(Material("paper", base_color=(0.8, 0.76, 0.66, 1.0), diffuse_transmission=0.4, double_sided=True))
    return builder


def _shell(b: Builder, x: float, z: float, high: float, holes: Sequence[Opening], paints: str) -> None:
    """Half sides x, z; holes in the wall at −X, seen from within from its left; paints of floor, walls and ceiling."""
    floor, walls, ceiling = paints.split(", ")
    b.add(floor, rooms.level(x, z, 0.0))
    b.add(ceiling, rooms.level(x, z, -high).mirrored(1))
    b.frame(0, (-x, 0, -z)).add(walls, rooms.wall(2 * x, high))
    b.frame(90, (-x, 0, z)).add(walls, rooms.wall(2 * z, high, holes, 0.3))
    b.frame(180, (x, 0, z)).add(walls, rooms.wall(2 * x, high))
    b.frame(-90, (x, 0, -z)).add(walls, rooms.wall(2 * z, high))
    b.add("white", rooms.skirting(rectangle((-x, -z), (x, z)), 0.1, closed=True))
    # No light comes in but by the holes.
    b.add("soil", block((-x - 0.3, high + 0.05, -z - 0.3), (x + 0.3, high + 0.25, z + 0.3)))


def _sun(height: float, bearing: float, irradiance: float = 12.0) -> Light:
    """From so high [degrees] over the horizon; bearing: from −X, towards −Z."""
    high, turn = radians(height), radians(bearing)
    way = (cos(high) * cos(turn), -sin(high), cos(high) * sin(turn))
    return Light("sun", LightKind.DIRECTIONAL, (irradiance, irradiance * 0.93, irradiance * 0.8), direction=way)


def _outside(b: Builder, half: float = 40.0) -> None:
    b.add("soil", quad((-half, -0.4, half), (2 * half, 0, 0), (0, 0, -2 * half)))


def _lit_by_sky(scene: Scene, height: float, bearing: float, strength: float) -> Scene:
    sky = np.asarray(daylight(height, bearing) * np.float32(strength), np.float32)
    return replace(scene, sky=Environment("sky", sky))


def classroom() -> Scene:
    """Lit by the sun alone, which is 35° high: desks and chairs of thin tubes, a board a little off the wall."""
    b = _builder("classroom")
    holes = [Opening(0.6 + 1.9 * n, 0.9, 2.2 + 1.9 * n, 2.6) for n in range(4)]
    _shell(b, 3.5, 4.2, 3.1, holes, "lino, white, white")
    wall = b.frame(90, (-3.5, 0, 4.2))
    for hole in holes:
        wall.add("white", rooms.window_frame(hole, -0.22, 2))
        wall.add("white", rooms.sill(hole, 0.1, 0.14))
    seat = tube([(-0.18, 0, -0.18), (-0.18, 0.44, -0.16), (-0.18, 0.85, -0.22)], 0.011, 8)
    chair = join([seat, seat.moved(0.36), *(cylinder(0.011, 0.44, 8).moved(x, 0, 0.18) for x in (-0.18, 0.18))])
    boards = join([box((0.4, 0.014, 0.4)).moved(0, 0.45, 0), box((0.4, 0.2, 0.012)).moved(0, 0.74, -0.2)])
    legs = join([cylinder(0.014, 0.72, 8).moved(x, 0, z) for x in (-0.55, 0.55) for z in (-0.22, 0.22)])
    top = join([box((1.2, 0.025, 0.55)).moved(0, 0.73, 0), box((1.1, 0.012, 0.4)).moved(0, 0.6, 0)])
    desks = [(x, 0.0, z) for x in (-2.2, 0.0, 2.2) for z in (-1.6, -0.2, 1.2, 2.6)]
    seats = np.array([(x + s, 0.0, z + 0.5) for x, _, z in desks for s in (-0.3, 0.3)])
    b.add("steel, wood", (legs, top), desks)
    turns = np.random.default_rng(3).uniform(160, 200, len(seats))
    b.add("steel, wood", (chair, boards), seats, turns)
    b.add("green", box((3.2, 1.2, 0.02)).moved(0.0, 1.5, -4.175))
    b.add(
        "wood",
        moulding(points("-.03,0 -.03,.03 0,.03 0,0"), rectangle((-1.6, -0.6), (1.6, 0.6)))
        .turned(90, "x")
        .moved(0, 1.5, -4.19),
    )
    covers, pages = books(5, 1.0, 0.26)
    b.add("wood", [box((0.32, 0.02, 1.2)).moved(3.3, y, 3.0) for y in (0.3, 0.7, 1.1)])
    b.frame(-90, (3.2, 0, 2.5)).add("red, white", (covers, pages), [(0, y, 0) for y in (0.311, 0.711, 1.111)])
    _outside(b)
    cameras = [
        look_at((2.9, 1.6, 3.8), (-1.4, 0.9, -1.8), yfov_degrees=58, name="back"),
        look_at((-2.6, 1.3, -3.6), (1.5, 0.6, 1.5), yfov_degrees=58, name="board"),
        look_at((0.7, 0.35, 0.5), (-0.6, 0.45, -1.6), yfov_degrees=50, name="legs"),
    ]
    return b.scene(cameras, [_sun(35.0, 25.0)])


def bathroom() -> Scene:
    """Glossy tiles with grout, a mirror, chrome and a glass screen, lit through a small window by a bright sky."""
    b = _builder("bathroom")
    b.light("daylight", (22.0, 24.0, 27.0))
    hole = Opening(1.1, 1.2, 2.0, 2.1)
    _shell(b, 1.5, 1.4, 2.5, [hole], "grout, grout, white")
    tile = box((0.148, 0.148, 0.008), 0.0015)
    grid = [((n + 0.5) * 0.15, (m + 0.5) * 0.15, 0.0) for n in range(20) for m in range(12)]
    b.frame(0, (-1.5, 0, -1.4)).add("tile", tile, grid)
    b.frame(180, (1.5, 0, 1.4)).add("tile", tile, grid)
    b.frame(-90, (1.5, 0, -1.4)).add("tile", tile, [place for place in grid if place[0] < 2.8])
    slab = box((0.296, 0.008, 0.296), 0.002)
    floor = [((n - 4.5) * 0.3, 0.0, (m - 4.0) * 0.3) for n in range(10) for m in range(9)]
    b.add("dark", slab, floor)
    b.add("mirror", quad((-0.6, 1.1, -1.385), (1.0, 0, 0), (0, 0.9, 0)))
    b.add("white", box((1.1, 0.12, 0.45), 0.02).moved(-0.1, 0.8, -1.15))
    b.add("chrome", tube([(-0.1, 0.86, -1.3), (-0.1, 1.02, -1.3), (-0.1, 1.02, -1.12)], 0.012, 12))
    b.add(
        "china",
        lathe([(0.0, 0.0), (0.2, 0.02), (0.24, 0.1), (0.225, 0.1), (0.18, 0.03), (0, 0.015)], 40).moved(
            -0.1, 0.861, -1.15
        ),
    )
    rim = [(0.3, 0.0), (0.36, 0.3), (0.38, 0.56), (0.35, 0.56), (0.33, 0.3), (0.27, 0.03), (0.0, 0.03)]
    tub = lathe(rim, 48)
    b.add("china", replace(tub, positions=tub.positions * (1.0, 1.0, 1.9)).moved(1.05, 0.01, 0.5))
    b.add("pane", quad((0.62, 0.57, -0.3), (0, 0, 1.5), (0, 1.4, 0)))
    b.add("chrome", [tube([(0.62, 0.56, z), (0.62, 1.98, z)], 0.01, 8) for z in (-0.31, 1.21)])
    b.add("cloth", curtain(0.6, 0.7, 5, 0.02, 4).turned(90).moved(-1.4, 0.9, -0.9))
    b.frame(90, (-1.5, 0, 1.4)).add("white", rooms.window_frame(hole, -0.15, 2))
    b.frame(90, (-1.5, 0, 1.4)).add("daylight", quad((0.9, 1.0, -0.34), (1.3, 0, 0), (0, 1.3, 0)))
    cameras = [
        look_at((1.2, 1.6, 1.2), (-0.4, 1.0, -1.2), yfov_degrees=62, name="mirror"),
        look_at((-1.2, 1.5, -1.0), (1.0, 0.7, 0.8), yfov_degrees=62, name="tub"),
    ]
    return b.scene(cameras)


def ajar() -> Scene:
    """Lit only through a door that is ajar by 18°, from a room with a bright lamp: cups, metal and glass on a table."""
    b = _builder("ajar")
    b.light("lamp", (260.0, 240.0, 200.0))
    _shell(b, 2.2, 2.0, 2.6, [Opening(1.4, 0.004, 2.4, 2.1)], "wood, white, white")
    leaf, _, handle = rooms.door(1.0, 2.09)
    hinge = b.frame(90 - 18, (-2.2, 0, -0.4))
    hinge.add("white, brass", [part.moved(-0.5) for part in (leaf, handle)])
    b.add("white", block((-6.5, 0, -2.6), (-6.4, 2.8, 2.6)))
    b.add("white", [block((-6.4, 0, s - 0.05), (-2.45, 2.8, s + 0.05)) for s in (-2.5, 2.5)])
    b.add("white", [block((-6.4, y, -2.5), (-2.5, y + 0.05, 2.5)) for y in (-0.05, 2.75)])
    b.add("lamp", block((-5.0, 2.3, 0.4), (-4.6, 2.5, 0.8)))
    b.add(
        "dark",
        [
            box((1.5, 0.03, 0.8)).moved(0.5, 0.7, 0),
            *(cylinder(0.025, 0.69, 12).moved(x, 0, z) for x in (-0.2, 1.2) for z in (-0.34, 0.34)),
        ],
    )
    b.add("china", mug(0.06, 0.11), [(0.2, 0.715, 0.1)])
    b.add("china", vase(0.12, 0.28), [(0.55, 0.715, -0.1)])
    b.add("steel", vase(0.12, 0.28), [(0.85, 0.715, 0.12)])
    b.add(
        "body",
        lathe([(0.0, 0.0), (0.06, 0.0), (0.08, 0.12), (0.076, 0.12), (0.056, 0.008), (0, 0.008)], 40),
        [(1.05, 0.716, -0.15)],
    )
    hanging = b.frame(-90, (2.2, 1.5, 0.0))
    hanging.add(
        "dark, blue",
        [
            moulding(points("-.035,.0005 -.035,.03 0,.02 0,.0005"), rectangle((-0.5, -0.35), (0.5, 0.35))).turned(
                90, "x"
            ),
            quad((-0.5, -0.35, 0.01), (1, 0, 0), (0, 0.7, 0)),
        ],
    )
    cameras = [
        look_at((2.0, 1.5, 1.8), (-1.2, 0.8, -0.6), yfov_degrees=55, name="door"),
        look_at((-1.9, 1.4, 1.5), (1.2, 0.8, -0.5), yfov_degrees=50, name="table"),
    ]
    return b.scene(cameras)


def kitchen() -> Scene:
    """Cabinets, a glossy worktop, tiles, pendants and glasses under a sky that comes through two windows."""
    b = _builder("kitchen")
    b.light("bulb", (60.0, 50.0, 36.0))
    holes = [Opening(0.7, 1.0, 1.9, 2.2), Opening(2.6, 1.0, 3.8, 2.2)]
    _shell(b, 2.1, 2.3, 2.6, holes, "tile, white, white")
    for hole in holes:
        b.frame(90, (-2.1, 0, 2.3)).add("white", rooms.window_frame(hole, -0.2, 2))
    doors = box((0.58, 0.68, 0.02), 0.004)
    b.add("grey", block((-2.0, 0.1, -2.29), (2.0, 0.86, -1.75)))
    b.add("blue", doors, [(x, 0.48, -1.735) for x in np.arange(-1.7, 2.0, 0.6)])
    b.add(
        "brass",
        tube([(-0.06, 0, 0.03), (0.06, 0, 0.03)], 0.006, 8),
        [(x, 0.76, -1.725) for x in np.arange(-1.7, 2.0, 0.6)],
    )
    b.add("black", box((4.06, 0.04, 0.62), 0.006).moved(0, 0.881, -1.98))
    tiles = [((n - 19.5) * 0.102, 0.954 + m * 0.102, -2.292) for n in range(40) for m in range(5)]
    b.add("tile", box((0.099, 0.099, 0.01), 0.002), tiles)
    b.add("blue", box((1.7, 0.7, 0.32), 0.006).moved(1.1, 1.85, -2.13))
    b.add("wood", [box((1.6, 0.025, 0.26)).moved(-1.1, y, -2.16) for y in (1.55, 1.9, 2.25)])
    b.add("china", mug(0.04, 0.09), [(x, y, -2.15) for x in np.arange(-1.8, -0.4, 0.13) for y in (1.563, 1.913)])
    b.add("china", saucer(0.1), [(-0.3 + 0.002 * n, 0.901 + 0.012 * n, -1.95) for n in range(8)])
    b.add(
        "steel",
        lathe([(0, 0), (0.12, 0), (0.12, 0.14), (0.117, 0.14), (0.117, 0.004), (0, 0.004)], 40),
        [(0.9, 0.902, -1.95)],
    )
    glass = lathe([(0.0, 0.0), (0.03, 0.0), (0.038, 0.12), (0.036, 0.12), (0.028, 0.006), (0, 0.006)], 32)
    b.add("body", glass, [(-1.1 + 0.1 * n, 0.902, -1.86) for n in range(4)])
    b.add(
        "wood",
        [
            box((1.5, 0.035, 0.8), 0.006).moved(0, 0.74, 0.6),
            *(box((0.06, 0.72, 0.06)).moved(x, 0.36, z) for x in (-0.68, 0.68) for z in (0.27, 0.93)),
        ],
    )
    b.add("wood, cloth", seating.wooden_chair(), [(-0.4, 0, 1.3), (0.4, 0, 1.35), (-0.9, 0, 0.6)], [180.0, 170.0, 90.0])
    dome, lining = pendant(0.95)
    b.add("black, white", (dome, lining), [(-0.4, 2.6, 0.6), (0.4, 2.6, 0.6)])
    b.add("bulb", sphere(0.035, 16), [(-0.4, 1.73, 0.6), (0.4, 1.73, 0.6)])
    _outside(b)
    cameras = [
        look_at((1.8, 1.55, 2.0), (-0.5, 0.9, -1.6), yfov_degrees=58, name="worktop"),
        look_at((0.2, 1.3, -1.2), (-0.9, 0.95, -2.1), yfov_degrees=50, name="glasses"),
    ]
    return _lit_by_sky(b.scene(cameras, [_sun(18.0, -20.0, 8.0)]), 18.0, 250.0, 2.5)


def bedroom() -> Scene:
    """A bed, curtains and mouldings; lamps in paper shades, sconces close to a wall; a dim evening sky."""
    b = _builder("bedroom")
    b.light("bulb", (420.0, 330.0, 220.0))
    hole = Opening(1.2, 0.5, 3.0, 2.3)
    _shell(b, 2.3, 2.1, 2.7, [hole], "wood, white, white")
    b.add("white", moulding(CORNICE, rectangle((-2.3, -2.1), (2.3, 2.1))).moved(y=2.7))
    wall = b.frame(90, (-2.3, 0, 2.1))
    wall.add("white", rooms.window_frame(hole, -0.2, 2))
    wall.add("paper", curtain(0.9, 2.45, 8, 0.04, 7).moved(1.5, 0, 0.12))
    wall.add("cloth", curtain(0.7, 2.45, 7, 0.04, 8).moved(3.2, 0, 0.12))
    b.add(
        "dark", [box((1.7, 0.3, 2.0), 0.02).moved(0.6, 0.2, -1.0), box((1.8, 1.0, 0.06), 0.02).moved(0.6, 0.6, -2.05)]
    )
    b.add("cloth", box((1.66, 0.22, 1.96), 0.07, 3, 3, 0.03).moved(0.6, 0.45, -1.0))
    b.add("white", furnishings.cushion(0.55), [(0.2, 0.62, -1.7), (1.0, 0.62, -1.7)])
    lining = drum_shade(0.15, 0.2)[1]
    for x in (-0.55, 1.8):
        b.add("wood", [box((0.42, 0.5, 0.4)).moved(x, 0.251, -1.85)])
        b.add("brass", [lathe([(0, 0), (0.08, 0.0), (0.02, 0.03), (0.012, 0.3), (0, 0.3)], 24).moved(x, 0.502, -1.85)])
        b.add("paper", [lining.moved(x, 0.78, -1.85)])
        b.add("bulb", [sphere(0.03, 16).moved(x, 0.86, -1.85)])
    # Sconces: half cylinders of steel 4 cm off the wall, with a bulb behind each.
    for z in (-0.6, 0.9):
        b.add("steel", [box((0.01, 0.3, 0.12)).moved(2.24, 1.7, z)])
        b.add("bulb", [box((0.012, 0.1, 0.03)).moved(2.272, 1.7, z)])
    frame = moulding(points("-.03,.0005 -.03,.025 0,.015 0,.0005"), rectangle((-0.3, -0.22), (0.3, 0.22))).turned(
        90, "x"
    )
    for n, x in enumerate((-1.5, -0.2, 0.6, 1.4)):
        at = b.frame(0, (x, 1.75, -2.1))
        at.add("dark, red" if n % 2 else "brass, blue", [frame, quad((-0.3, -0.22, 0.01), (0.6, 0, 0), (0, 0.44, 0))])
    covers, pages = books(11, 0.9, 0.24)
    b.add("white", [box((1.0, 0.02, 0.26)).moved(-0.6, y, 1.96) for y in (0.4, 0.8, 1.2, 1.6)])
    b.frame(180, (-0.15, 0, 1.84)).add("green, white", (covers, pages), [(0, y, 0) for y in (0.411, 0.811, 1.211)])
    cameras = [
        look_at((-1.9, 1.5, 1.7), (0.7, 0.8, -1.6), yfov_degrees=60, name="bed"),
        look_at((1.9, 1.4, -0.9), (-1.3, 1.0, 1.6), yfov_degrees=60, name="shelf"),
        look_at((0.2, 1.5, 1.2), (2.3, 1.5, 0.3), yfov_degrees=60, name="sconces"),
    ]
    return _lit_by_sky(b.scene(cameras), 3.0, 200.0, 0.6)


def spaceship() -> Scene:
    """A cabin of metal and dark lacquer; strips of light behind coves."""
    b = _builder("spaceship")
    b.light("strip", (26.0, 32.0, 42.0))
    b.light("amber", (40.0, 18.0, 4.0))
    b.material(
        Material("lacquer", base_color=(0.05, 0.06, 0.08, 1.0), roughness=0.4, clearcoat=1.0, clearcoat_roughness=0.05)
    )
    _shell(b, 2.6, 1.6, 2.2, [], "black, steel, grey")
    for side in (-1, 1):
        b.add("grey", [block((-2.5, 1.95, min(side * 1.25, side * 1.33)), (2.5, 2.05, max(side * 1.25, side * 1.33)))])
        b.add("strip", [block((-2.4, 1.97, min(side * 1.40, side * 1.44)), (2.4, 2.0, max(side * 1.40, side * 1.44)))])
        b.add(
            "steel",
            [
                tube([(x, 0.1, side * 1.57), (x, 1.6, side * 1.5), (x, 2.15, side * 1.2)], 0.03, 10)
                for x in np.arange(-2.2, 2.4, 0.55)
            ],
        )
    b.add("lacquer", [box((1.0, 0.8, 0.5), 0.06, 3).moved(x, 0.42, -1.2) for x in (-1.4, 0.2, 1.8)])
    b.add("amber", [box((0.3, 0.01, 0.02)).moved(x, 0.83, -1.1) for x in (-1.4, 0.2, 1.8)])
    b.add("chrome", sphere(0.22), [(-0.6, 0.23, 0.4)])
    b.add("red", box((0.5, 0.5, 0.5), 0.05, 3).moved(0.8, 0.26, 0.6))
    b.add("brass", vase(0.15, 0.4), [(1.6, 0.001, 0.3)])
    cameras = [
        look_at((-2.4, 1.4, 1.0), (1.2, 0.7, -0.4), yfov_degrees=62, name="cabin"),
        look_at((2.3, 1.2, 0.9), (-1.0, 0.5, -0.9), yfov_degrees=62, name="stern"),
    ]
    return b.scene(cameras)


def steel_room() -> Scene:
    """All of rough metal, with a lamp below the ceiling."""
    b = _builder("steel-room")
    b.light("lamp", (30.0, 28.0, 25.0))
    _shell(b, 2.0, 2.0, 2.5, [], "steel, steel, steel")
    b.add("lamp", quad((-0.5, 2.45, -0.5), (1, 0, 0), (0, 0, 1)))
    b.add("steel", [box((0.8, 0.8, 0.8), 0.02).turned(20).moved(-0.6, 0.41, -0.5), sphere(0.4).moved(0.8, 0.41, 0.2)])
    return b.scene([look_at((1.7, 1.5, 1.8), (-0.4, 0.7, -0.8), yfov_degrees=60, name="room")])


def hall() -> Scene:
    """200 m long, 10 km from the origin, light tubes behind coves; and a cup of 5 cm on a sill that a camera is at."""
    b = _builder("hall")
    b.light("tube", (900.0, 860.0, 800.0))
    at = b.frame(0, (1e4, 0.0, -1e4))
    at.add("tile", rooms.level(100.0, 15.0, 0.0))
    at.add("white", rooms.level(100.0, 15.0, -14.0).mirrored(1))
    for degrees, x, z, wide in ((0, -100, -15, 200), (180, 100, 15, 200), (90, -100, 15, 30), (-90, 100, -15, 30)):
        b.frame(degrees, (1e4 + x, 0, -1e4 + z)).add("cloth", rooms.wall(wide, 14.0))
    column = lathe([(0.0, 0), (0.9, 0), (0.9, 0.5), (0.6, 0.7), (0.55, 11.0), (0.8, 11.6), (0.8, 12.0), (0, 12.0)], 32)
    at.add("white", column, [(x, 0, z) for x in np.arange(-95, 100, 10.0) for z in (-10, 10)])
    for side in (-1, 1):
        at.add("white", [box((198, 0.8, 0.1)).moved(0, 12.6, side * 13.6)])
        at.add("tube", [box((197, 0.1, 0.1)).moved(0, 12.4, side * 14.2)])
    at.add("wood", [box((2.0, 0.4, 0.6)).moved(x, 0.25, z) for x in np.arange(-90, 100, 6.0) for z in (-6, 6)])
    at.add(
        "china, red", [mug(0.025, 0.05), box((0.12, 0.02, 0.09), 0.002).moved(0.1, 0.01, 0.0)], [(0.0, 0.4515, -6.0)]
    )
    cameras = [
        look_at((1e4 - 90, 1.7, -1e4 + 3), (1e4, 4.0, -1e4 - 4), yfov_degrees=60, name="nave"),
        look_at((1e4 + 0.25, 0.65, -1e4 - 5.7), (1e4, 0.47, -1e4 - 6.02), yfov_degrees=40, name="cup"),
    ]
    return b.scene(cameras)


ROOMS: dict[str, Callable[[], Scene]] = {
    make.__name__.replace("_", "-"): make
    for make in (classroom, bathroom, ajar, kitchen, bedroom, spaceship, steel_room, hall)
}
