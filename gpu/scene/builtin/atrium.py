"""A courtyard under the sun: an arcade of fluted columns around a fountain, frescoes in the shade of the walk."""

import numpy as np

from gpu.scene.builtin import furnishings, orders, paintings, rooms, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.rooms import LAP, Placer
from gpu.scene.builtin.shape import Shape, copies, placed
from gpu.scene.builtin.shapes import box, moulding, picture, quad, rectangle, surface
from gpu.scene.camera import look_at
from gpu.scene.types import Light, LightKind, Scene, Sky

_BAY, _BAYS = 2.4, (5, 3)  # metres between columns; bays along x and z
_X, _Z = _BAY * _BAYS[0] / 2, _BAY * _BAYS[1] / 2  # the columns' axes
_OUT_X, _OUT_Z = _X + 3.0, _Z + 3.0  # the outer walls
_KERB, _COURT = 0.014, -0.15  # height of the columns' kerb and of the court's paving
_SPRING, _WALL_TOP, _CEILING, _TERRACE = 3.2, 4.95, 5.02, 5.3
_THICK = 0.36


def make() -> Scene:
    """The whole court with its sun and a blue sky."""
    builder = Builder("atrium")
    stone = builder.textured("limestone", textures.plaster(61, "#dccfb6", 0.035), (1.3, 1.3), 0.8)
    marble = textures.marble(62, ["#a79a8c", "#cfc4b4", "#ebe3d6"], 0.5)
    white = builder.textured("marble", marble, (1.1, 1.1), 0.4)
    oak = builder.textured("beams", textures.wood(63, ["#59402a", "#7c5b3d", "#97744f"]), (1.6, 0.4), 0.7)
    _floors(builder, stone)
    _arcade(builder, stone, white)
    _entablature(builder, stone)
    _walk(builder, stone, oak)
    _court(builder, stone, white)
    direction = np.array([0.42, -1.43, -1.0])
    direction /= np.linalg.norm(direction)
    sun = Light("sun", LightKind.DIRECTIONAL, (15.0, 13.3, 10.6), direction=tuple(direction.tolist()))
    return builder.scene(
        [
            look_at((5.3, 1.6, 0.9), (-3.0, 2.0, -1.75), yfov_degrees=60, name="court"),
            look_at((8.3, 1.62, -5.0), (-6.0, 1.6, -4.75), yfov_degrees=55, name="north walk"),
            look_at((-8.3, 1.6, 0.35), (0.0, 1.8, -0.55), yfov_degrees=55, name="through the arch"),
        ],
        [sun],
        Sky((0.95, 1.6, 2.9)),
    )


def _ring(inner: tuple[float, float], outer: tuple[float, float], y: float) -> Shape:
    """The level frame between two rectangles of half sides (x, z), facing up; UVs are (x, z)."""
    rows = []
    for x, z in (outer, inner):
        plan = rectangle((-x, -z), (x, z))
        rows.append(np.insert(plan[[0, 1, 2, 3, 0]], 1, y, axis=1))
    shape = surface(rows)
    return Shape(shape.positions, shape.triangles, shape.normals, shape.positions[:, [0, 2]])


def _floors(builder: Builder, stone: int) -> None:
    grounds = [["#8d7a66", "#c9b89c", "#e4d9c4"], ["#6f3b30", "#8f5545", "#a87262"]]
    tiles = textures.marble_tiles(64, grounds, 4)
    builder.add(
        builder.textured("marble tiles", tiles, (2.4, 2.4), 0.3),
        _ring((_X + 0.25, _Z + 0.25), (_OUT_X + LAP, _OUT_Z + LAP), 0),
    )
    flags = textures.marble_tiles(
        65, [["#8a755c", "#a48d70", "#b8a284"], ["#7d6a55", "#957f66", "#aa957a"]], 3, "#6b5f50"
    )
    x, z = _X - 0.29, _Z - 0.29
    paving = quad((-x, _COURT, z), (2 * x, 0, 0), (0, 0, -2 * z))
    builder.add(builder.textured("flagstones", flags, (2.1, 2.1), 0.8), paving)
    kerb = [(-0.6, -0.2), (-0.6, _KERB - 0.006), (-0.594, _KERB), (-0.012, _KERB), (0.0, _KERB - 0.012), (0.0, -0.2)]
    builder.add(stone, moulding(kerb, rectangle((-_X + 0.3, -_Z + 0.3), (_X - 0.3, _Z - 0.3))))


def _sides() -> list[tuple[float, int, float]]:
    """The court's four sides as (turn in degrees, bays, distance of the columns from the middle); they face inwards."""
    return [(0.0, _BAYS[0], _Z), (180.0, _BAYS[0], _Z), (90.0, _BAYS[1], _X), (-90.0, _BAYS[1], _X)]


def _along(turn: float, bays: int, distance: float, xs: list[float], y: float) -> tuple[list[list[float]], float]:
    """Places on one side of the court at `xs` along it, and the turn that makes a shape's +Z face the court."""
    place = Placer(turn, (0.0, y, 0.0))
    angle = np.radians(place.degrees)
    c, s = np.cos(angle), np.sin(angle)
    return [[x * c - distance * s, y, -x * s - distance * c] for x in xs], turn


def _arcade(builder: Builder, stone: int, white: int) -> None:
    warm = builder.textured("arcade plaster", textures.plaster(66, "#e2cda6", 0.025), (2.0, 2.0), 0.95)
    high = _SPRING - _KERB
    around = [(x, z) for x in np.linspace(-_X, _X, _BAYS[0] + 1) for z in (-_Z, _Z)]
    around += [(x, z) for x in (-_X, _X) for z in np.linspace(-_Z, _Z, _BAYS[1] + 1)[1:-1]]
    builder.add(white, placed(orders.column(high, 0.19), [(x, _KERB, z) for x, z in around]))

    radius = _BAY / 2 - 0.23
    bay = orders.arch_bay(_BAY, radius, _WALL_TOP - _SPRING, _THICK)
    rim = orders.archivolt(radius, 0.2, 0.05).moved(z=_THICK / 2)
    key = orders.keystone(0.34).moved(0, radius + 0.12, _THICK / 2 + 0.02)
    for turn, bays, distance in _sides():
        xs = [(number - (bays - 1) / 2) * _BAY for number in range(bays)]
        places, angle = _along(turn, bays, distance, xs, _SPRING - 0.002)
        builder.add(warm, placed(bay, places, angle))
        builder.add(stone, placed(rim, places, angle), placed(rim.turned(180), places, angle))
        builder.add(stone, placed(key, places, angle), placed(key.turned(180), places, angle))
    corner = box((_THICK + 0.02, _WALL_TOP - _SPRING + 0.002, _THICK + 0.02), 0.006, 2)
    middle = (_SPRING + _WALL_TOP) / 2
    builder.add(warm, copies(corner, [(x, middle, z) for x in (-_X, _X) for z in (-_Z, _Z)]))


def _entablature(builder: Builder, stone: int) -> None:
    """The cornice over the arcade with dentils, and a balustrade on it."""
    face = _THICK / 2
    section = [(-0.42, 4.9), (-0.42, _TERRACE), (0.3, _TERRACE), (0.3, 5.25), (0.27, 5.23), (0.24, 5.17), (0.19, 5.14)]
    section += [(0.19, 5.12), (0.07, 5.12), (0.07, 5.0), (0.045, 4.98), (0.03, 4.94), (0.03, 4.9)]
    builder.add(stone, moulding(section, rectangle((-_X + face, -_Z + face), (_X - face, _Z - face))))
    dentil = box((0.085, 0.09, 0.08), 0.0).moved(0, 5.07, face + 0.1)
    rail_low, rail_high = _TERRACE + 0.12, _TERRACE + 0.78
    for turn, bays, distance in _sides():
        half = bays * _BAY / 2 - face
        xs = np.linspace(-half + 0.1, half - 0.1, round((2 * half - 0.2) / 0.17) + 1).tolist()
        places, angle = _along(turn, bays, distance, xs, 0.0)
        builder.add(stone, placed(dentil, places, angle))
        spots = [
            x + (number + 0.5) * _BAY / 8 for x in np.arange(bays) * _BAY - bays * _BAY / 2 for number in range(1, 7)
        ]
        places, angle = _along(turn, bays, distance, spots, rail_low - 0.001)
        builder.add(stone, placed(orders.baluster(rail_high - rail_low + 0.002), places, angle))
        posts = [number * _BAY - bays * _BAY / 2 for number in range(1, bays)]
        places, angle = _along(turn, bays, distance, posts, (_TERRACE + rail_high) / 2)
        builder.add(stone, placed(box((0.26, rail_high - _TERRACE, 0.24), 0.008), places, angle))
    for low, high, half in ((_TERRACE - 0.002, rail_low, 0.11), (rail_high, rail_high + 0.12, 0.13)):
        rail = [
            (-half, low),
            (-half, high - 0.015),
            (-half + 0.015, high),
            (half - 0.015, high),
            (half, high - 0.015),
            (half, low),
        ]
        builder.add(stone, moulding(rail, rectangle((-_X, -_Z), (_X, _Z))))
    post = box((0.36, rail_high + 0.2 - _TERRACE, 0.36), 0.01)
    corners = [(x, (_TERRACE + rail_high + 0.2) / 2, z) for x in (-_X, _X) for z in (-_Z, _Z)]
    builder.add(stone, copies(post, corners))
    tops = [(x, rail_high + 0.2005, z) for x, _, z in corners]
    builder.add(stone, placed(orders.urn(0.62), tops))


def _walk(builder: Builder, stone: int, oak: int) -> None:
    """The covered walk: outer walls with dado and pilasters, beamed ceiling, doors, frescoes."""
    ochre = builder.textured("ochre plaster", textures.plaster(67, "#dfbf8a", 0.03), (2.0, 2.0), 0.95)
    red = builder.textured("red plaster", textures.plaster(68, "#97483a", 0.04), (2.0, 2.0), 0.9)
    boards = builder.textured(
        "ceiling boards", textures.planks(69, ["#6a4e35", "#8b6a49", "#a5835d"], 8, 2, 512), (2.4, 1.6), 0.8
    )
    ceiling = _ring((_X + 0.2, _Z + 0.2), (_OUT_X + LAP, _OUT_Z + LAP), 0.0).mirrored(1).moved(y=_CEILING)
    builder.add(boards, ceiling)
    dado = 1.05
    rail = [
        (-0.002, dado - 0.05),
        (-0.002, dado + 0.03),
        (0.035, dado + 0.03),
        (0.04, dado + 0.02),
        (0.022, dado - 0.03),
        (0.01, dado - 0.05),
    ]
    plan = rectangle((-_OUT_X, -_OUT_Z), (_OUT_X, _OUT_Z))
    builder.add(stone, moulding(rail, plan), rooms.skirting(plan, 0.16, 0.02, closed=True))
    walls = [(0.0, _OUT_X, _OUT_Z), (180.0, _OUT_X, _OUT_Z), (90.0, _OUT_Z, _OUT_X), (-90.0, _OUT_Z, _OUT_X)]
    for turn, half, distance in walls:
        (origin,), _ = _along(turn, 0, distance, [-half], 0.0)
        place = Placer(turn, (origin[0], 0.0, origin[2]))
        builder.add(red, place(rooms.wall(2 * half, dado)))
        builder.add(ochre, place(rooms.wall(2 * half, _CEILING - dado).moved(y=dado)))
    pilaster = box((0.42, _CEILING - 0.2, 0.12), 0.01)
    cap = box((0.5, 0.16, 0.18), 0.02, 2)
    beam = box((0.16, 0.22, 2.9), 0.01)
    for turn, bays, distance in _sides():
        xs = [number * _BAY - bays * _BAY / 2 for number in range(bays + 1)]
        places, angle = _along(turn, bays, distance + 2.98, xs, 0.0)
        builder.add(stone, placed(pilaster.moved(y=(_CEILING - 0.2) / 2 - 0.001), places, angle))
        builder.add(
            stone,
            placed(cap.moved(y=_CEILING - 0.29), places, angle),
            placed(box((0.5, 0.2, 0.18), 0.01).moved(y=0.0995), places, angle),
        )
        places, angle = _along(turn, bays, distance + 1.58, xs, _CEILING - 0.105)
        builder.add(oak, placed(beam, places, angle))
    _frescoes(builder, stone)
    _doors(builder, stone, oak)


def _frescoes(builder: Builder, stone: int) -> None:
    skies = ["#8fb0bd", "#cfd8cb", "#f0dfb8"], ["#c98f74", "#e8c79c", "#f3e3bd"]
    hills = ["#b3b09a", "#8c9a78", "#667a58", "#4d5d47"], ["#b08f78", "#96705a", "#6e6a50", "#535c45"]
    walls = [
        builder.textured(
            "fresco", paintings.landscape(70 + number, skies[number % 2], hills[number % 2]), roughness=0.9
        )
        for number in range(3)
    ]
    wide, tall = 1.5, 1.75
    frame = rooms.picture_frame(wide, tall, 0.06, 0.05)
    for side, (turn, xs) in enumerate(((0.0, (-4.8, -2.4, 0.0, 2.4, 4.8)), (180.0, (-4.8, -2.4, 2.4, 4.8)))):
        places, angle = _along(turn, 0, _OUT_Z, list(xs), 2.3)
        builder.add(stone, placed(frame, places, angle))
        for number, place in enumerate(places):
            builder.add(walls[(number + side) % 3], placed(picture(wide, tall).moved(z=0.012), [place], angle))


def _doors(builder: Builder, stone: int, oak: int) -> None:
    bronze = builder.paint("bronze", "#6d5a40", 0.4)
    leaf, casing, handle = rooms.door(1.25, 2.7)
    spots = [(turn, distance, 0.0) for turn, distance in ((90.0, _OUT_X), (-90.0, _OUT_X), (180.0, _OUT_Z))]
    for turn, distance, x in spots:
        places, angle = _along(turn, 0, distance - 0.045, [x], 0.0)
        builder.add(oak, placed(leaf.mapped_uv(swap=True), places, angle))
        builder.add(stone, placed(casing, places, angle), placed(casing.moved(z=-0.02), places, angle))
        builder.add(bronze, placed(handle, places, angle))


def _court(builder: Builder, stone: int, white: int) -> None:
    """Fountain, clipped trees in tubs, benches, urns in the corners of the walk."""
    basin, water = orders.fountain(1.35)
    builder.add(white, basin.moved(0, _COURT, 0))
    builder.add(builder.paint("water", "#6f9a9c", 0.05), water.moved(0, _COURT, 0))

    clay = builder.paint("terracotta", "#b4714e", 0.9)
    earth = builder.paint("soil", "#4d4136", 1.0)
    bark = builder.paint("bark", "#77654e", 0.9)
    green = builder.textured("box leaves", textures.leaves(73, ["#35552b", "#567a3c", "#8ca65f"]), (1.0, 1.0), 0.6)
    shade = builder.paint("box core", "#3c4f2e", 1.0)
    places = [(x, _COURT + 0.0005, z) for x in (-4.3, 4.3) for z in (-2.2, 2.2)]
    planter, soil = furnishings.pot(0.32, 0.5)
    ball, core = furnishings.topiary(74, 0.48, 700)
    trunk = orders.trunk(0.035, 0.42, 1.2)
    turns = np.arange(4) * 47.0
    for material, shape in (
        (clay, planter),
        (earth, soil),
        (bark, trunk),
        (green, ball.moved(y=1.45)),
        (shade, core.moved(y=1.45)),
    ):
        builder.add(material, placed(shape, places, turns))

    seat = box((1.5, 0.09, 0.42), 0.015, 3).moved(0, 0.435, 0)
    foot = box((0.14, 0.395, 0.34), 0.012).moved(0, 0.1925, 0)
    for x, z, turn in (
        (-3.6, _OUT_Z - 0.4, 180.0),
        (3.6, _OUT_Z - 0.4, 180.0),
        (-3.6, 0.4 - _OUT_Z, 0.0),
        (3.6, 0.4 - _OUT_Z, 0.0),
    ):
        place = Placer(turn, (x, 0.0005, z))
        builder.add(white, place(seat), *(place(foot.moved(side * 0.5)) for side in (-1, 1)))
    corners = [(sx * (_OUT_X - 0.55), sz * (_OUT_Z - 0.55)) for sx in (-1, 1) for sz in (-1, 1)]
    builder.add(stone, copies(box((0.5, 0.55, 0.5), 0.02, 2), [(x, 0.2755, z) for x, z in corners]))
    builder.add(clay, placed(orders.urn(0.8), [(x, 0.551, z) for x, z in corners]))
