"""A courtyard under the sun: an arcade of fluted columns around a fountain, frescoes in the shade of the walk."""

from dataclasses import replace
from functools import partial

import numpy as np

from gpu.scene.builtin import orders, paintings, rooms, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.furnishings import pot, vase
from gpu.scene.builtin.rooms import LAP
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.shapes import box, lathe, moulding, points, quad, rectangle, surface
from gpu.scene.camera import look_at
from gpu.scene.types import Light, LightKind, Scene, Sky

_BAY, _BAYS = 2.4, (5, 3)  # metres between columns; bays along x and z
_X, _Z = _BAY * _BAYS[0] / 2, _BAY * _BAYS[1] / 2  # the columns' axes
_OUT_X, _OUT_Z = _X + 3.0, _Z + 3.0  # the outer walls
_KERB, _COURT = 0.014, -0.15  # height of the columns' kerb and of the court's paving
_SPRING, _WALL_TOP, _CEILING, _TERRACE = 3.2, 4.95, 5.02, 5.3
_THICK = 0.36
_CORNERS = [(x, z) for x in (-1, 1) for z in (-1, 1)]


def make() -> Scene:
    """The whole court with its sun and a blue sky."""
    builder = Builder("atrium")
    builder.textured("limestone", partial(textures.plaster, 61, "#dccfb6", 0.035), (1.3, 1.3), 0.8)
    builder.textured("marble", partial(textures.marble, 62, "#a79a8c #cfc4b4 #ebe3d6", 0.5), (1.1, 1.1), 0.4)
    builder.textured("beams", partial(textures.wood, 63, "#59402a #7c5b3d #97744f"), (1.6, 0.4), 0.7)
    for part in (_floors, _arcade, _entablature, _walk, _frescoes_and_doors, _court):
        part(builder)
    direction = np.array([0.42, -1.43, -1.0])
    direction /= np.linalg.norm(direction)
    sun = Light("sun", LightKind.DIRECTIONAL, (15.0, 13.3, 10.6), direction=tuple(direction.tolist()))
    views = [
        look_at((5.3, 1.6, 0.9), (-3.0, 2.0, -1.75), yfov_degrees=60, name="court"),
        look_at((8.3, 1.62, -5.0), (-6.0, 1.6, -4.75), yfov_degrees=55, name="north walk"),
        look_at((-8.3, 1.6, 0.35), (0.0, 1.8, -0.55), yfov_degrees=55, name="through the arch"),
    ]
    return builder.scene(views, [sun], Sky((0.95, 1.6, 2.9)))


def _sides(builder: Builder, out: float) -> list[tuple[Builder, list[float]]]:
    """The court's sides, `out` metres behind the columns' axes: a frame facing inwards, and the columns' x in it."""
    x, z = _X + out, _Z + out
    frames = [(0, (0, 0, -z)), (180, (0, 0, z)), (90, (-x, 0, 0)), (-90, (x, 0, 0))]
    xs = [[(number - bays / 2) * _BAY for number in range(bays + 1)] for bays in _BAYS]
    return [(builder.frame(*frame), xs[number // 2]) for number, frame in enumerate(frames)]


def _ring(inner: float) -> Shape:
    """The level frame at y = 0 from `inner` metres outside the columns to the walls, facing up; UVs are (x, z)."""
    plans = rectangle((-_OUT_X - LAP, -_OUT_Z - LAP), (_OUT_X + LAP, _OUT_Z + LAP)), _court_plan(inner)
    shape = surface([np.insert(plan[[0, 1, 2, 3, 0]], 1, 0.0, axis=1) for plan in plans])
    return replace(shape, uvs=shape.positions[:, [0, 2]])


def _court_plan(out: float) -> np.ndarray:
    """The rectangle of the columns' axes, `out` metres larger on every side."""
    return rectangle((-_X - out, -_Z - out), (_X + out, _Z + out))


def _floors(builder: Builder) -> None:
    marbles = ("#8d7a66 #c9b89c #e4d9c4", "#6f3b30 #8f5545 #a87262")
    builder.textured("marble tiles", partial(textures.tiles, 64, marbles, 4, "#8a857c"), (2.4, 2.4), 0.3)
    builder.add("marble tiles", _ring(0.25))
    flags = ("#8a755c #a48d70 #b8a284", "#7d6a55 #957f66 #aa957a")
    builder.textured("flagstones", partial(textures.tiles, 65, flags, 3, "#6b5f50"), (2.1, 2.1), 0.8)
    x, z = _X - 0.29, _Z - 0.29
    builder.add("flagstones", quad((-x, _COURT, z), (2 * x, 0, 0), (0, 0, -2 * z)))
    kerb = [(-0.6, -0.2), (-0.6, _KERB - 0.006), (-0.594, _KERB), (-0.012, _KERB), (0.0, _KERB - 0.012), (0.0, -0.2)]
    builder.add("limestone", moulding(kerb, _court_plan(-0.3)))


def _arcade(builder: Builder) -> None:
    builder.textured("arcade plaster", partial(textures.plaster, 66, "#e2cda6", 0.025), (2.0, 2.0), 0.95)
    grid = [(x, _KERB, z) for x in np.linspace(-_X, _X, _BAYS[0] + 1) for z in np.linspace(-_Z, _Z, _BAYS[1] + 1)]
    around = [(x, y, z) for x, y, z in grid if abs(x) == _X or abs(z) == _Z]
    builder.add("marble", orders.column(_SPRING - _KERB, 0.19), around)
    arch = orders.arch(_BAY, _WALL_TOP - _SPRING, _THICK)
    for side, xs in _sides(builder, 0.0):
        side.add("arcade plaster, limestone", arch, [(x + _BAY / 2, _SPRING - 0.002, 0.0) for x in xs[:-1]])
    corner = box((_THICK + 0.02, _WALL_TOP - _SPRING + 0.002, _THICK + 0.02), 0.006)
    builder.add("arcade plaster", corner, [(x * _X, (_SPRING + _WALL_TOP) / 2, z * _Z) for x, z in _CORNERS])


def _entablature(builder: Builder) -> None:
    """The cornice over the arcade with dentils, and a balustrade on it."""
    face = _THICK / 2
    cornice = points("-.42,4.9 -.42,5.3 .3,5.3 .3,5.25 .27,5.23 .24,5.17 .19,5.14 .19,5.12")
    cornice += points(".07,5.12 .07,5 .045,4.98 .03,4.94 .03,4.9")
    builder.add("limestone", moulding(cornice, _court_plan(-face)))
    low, high = _TERRACE + 0.12, _TERRACE + 0.78
    dentil = box((0.085, 0.09, 0.08), 0.0)
    post = box((0.26, high - _TERRACE, 0.24), 0.008)
    for side, xs in _sides(builder, 0.0):
        end = xs[-1] - face - 0.1
        teeth = np.linspace(-end, end, round(2 * end / 0.17) + 1)
        side.add("limestone", dentil, [(x, 5.07, face + 0.1) for x in teeth])
        slots = [(x + (number + 0.5) * _BAY / 8, low - 0.001, 0.0) for x in xs[:-1] for number in range(1, 7)]
        side.add("limestone", orders.baluster(), slots)
        side.add("limestone", post, [(x, (_TERRACE + high) / 2, 0.0) for x in xs[1:-1]])
    for bottom, top, wide in ((_TERRACE - 0.002, low, 0.11), (high, high + 0.12, 0.13)):
        rail = [(-wide, bottom), (-wide, top - 0.015), (-wide + 0.015, top)]
        rail += [(-x, y) for x, y in reversed(rail)]
        builder.add("limestone", moulding(rail, _court_plan(0.0)))
    places = np.array([(x * _X, high + 0.2005, z * _Z) for x, z in _CORNERS])
    post = box((0.36, high + 0.2 - _TERRACE, 0.36), 0.01).moved(y=(_TERRACE - high - 0.201) / 2)
    builder.add("limestone", [post, vase(0.17, 0.62)], places)


def _walk(builder: Builder) -> None:
    """The covered walk: outer walls with dado and pilasters, beamed ceiling."""
    builder.textured("ochre plaster", partial(textures.plaster, 67, "#dfbf8a", 0.03), (2.0, 2.0), 0.95)
    builder.textured("red plaster", partial(textures.plaster, 68, "#97483a", 0.04), (2.0, 2.0), 0.9)
    boards = partial(textures.planks, 69, "#6a4e35 #8b6a49 #a5835d", size=512)
    builder.textured("ceiling boards", boards, (2.4, 1.6), 0.8)
    builder.add("ceiling boards", _ring(0.2).mirrored(1).moved(y=_CEILING))
    rail = points("-.002,1 -.002,1.08 .035,1.08 .04,1.07 .022,1.02 .01,1")
    plan = rectangle((-_OUT_X, -_OUT_Z), (_OUT_X, _OUT_Z))
    builder.add("limestone", [moulding(rail, plan), rooms.skirting(plan, 0.16, closed=True)])
    for side, xs in _sides(builder, 3.0):
        half = xs[-1] + 3.0
        side.add("red plaster", rooms.wall(2 * half, 1.05).moved(x=-half))
        side.add("ochre plaster", rooms.wall(2 * half, _CEILING - 1.05).moved(x=-half, y=1.05))
    pilaster = box((0.42, _CEILING - 0.2, 0.12), 0.01).moved(y=(_CEILING - 0.2) / 2 - 0.001)
    ends = [box((0.5, 0.16, 0.18), 0.02).moved(y=_CEILING - 0.29), box((0.5, 0.2, 0.18), 0.01).moved(y=0.0995)]
    beam = box((0.16, 0.22, 2.9), 0.01).moved(0, _CEILING - 0.105, 1.4)
    for side, xs in _sides(builder, 2.98):
        side.add("limestone, beams", (join([pilaster, *ends]), beam), [(x, 0.0, 0.0) for x in xs])


def _frescoes_and_doors(builder: Builder) -> None:
    skies = ("#8fb0bd #cfd8cb #f0dfb8", "#c98f74 #e8c79c #f3e3bd")
    hills = ("#b3b09a #8c9a78 #667a58 #4d5d47", "#b08f78 #96705a #6e6a50 #535c45")
    for number, x in enumerate((-4.8, -2.4, 0.0, 2.4, 4.8)):
        fresco = partial(paintings.landscape, 70 + number, skies[number % 2], hills[number % 2])
        rooms.hang(builder.frame(0.0, (x, 2.3, -_OUT_Z)), "limestone", fresco, 1.5, 1.75)
        if x:  # a door is in the middle
            rooms.hang(builder.frame(180.0, (x, 2.3, _OUT_Z)), "limestone", fresco, 1.5, 1.75)
    builder.paints("bronze #6d5a40 0.4")
    leaf, casing, handle = rooms.door(1.25, 2.7)
    parts = (leaf.mapped_uv(swap=True), casing, casing.moved(z=-0.02), handle)
    for side, _ in _sides(builder, 2.955)[1:]:
        side.add("beams, limestone, limestone, bronze", parts)


def _court(builder: Builder) -> None:
    """Fountain, clipped trees in tubs, benches, urns in the corners of the walk."""
    builder.paints("water #6f9a9c 0.05")
    builder.add("marble, water", orders.fountain(1.35), (0, _COURT, 0))
    builder.paints("terracotta #b4714e 0.9, soil #4d4136 1.0, bark #77654e 0.9")
    builder.textured("box leaves", partial(textures.leaves, 73, "#35552b #567a3c #8ca65f"), (1.0, 1.0), 0.6)
    builder.paints("box core #3c4f2e 1.0")
    trunk = lathe(points(".035,.42 .028,.81 .026,1.2"), 16)
    ball, core = (part.moved(y=1.45) for part in orders.topiary(74, 0.48))
    places = [(x * 4.3, _COURT + 0.0005, z * 2.2) for x, z in _CORNERS]
    tree = (*pot(0.32, 0.5), trunk, ball, core)
    builder.add("terracotta, soil, bark, box leaves, box core", tree, places, 47.0 * np.arange(4))
    foot = box((0.14, 0.395, 0.34), 0.012).moved(0, 0.1925, 0)
    seat = box((1.5, 0.09, 0.42), 0.015, 3).moved(0, 0.435, 0)
    benches = [(x * 3.6, 0.0005, z * (_OUT_Z - 0.4)) for x, z in _CORNERS]
    builder.add("marble", [seat, foot.moved(0.5), foot.moved(-0.5)], benches)
    corners = [(x * (_OUT_X - 0.55), 0.2755, z * (_OUT_Z - 0.55)) for x, z in _CORNERS]
    builder.add("limestone, terracotta", (box((0.5, 0.55, 0.5), 0.02, 2), vase(0.22, 0.8).moved(y=0.2755)), corners)
