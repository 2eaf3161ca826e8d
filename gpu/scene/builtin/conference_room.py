"""A conference room in daylight: a long table, thin-legged chairs, ceiling panels, venetian blinds."""

import numpy as np

from gpu.scene.builtin import furnishings, paintings, rooms, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.rooms import Opening, Placer
from gpu.scene.builtin.shape import Shape, copies, join, placed, warped
from gpu.scene.builtin.shapes import (
    block,
    box,
    cylinder,
    lathe,
    moulding,
    picture,
    quad,
    rectangle,
    rounded_path,
    slab,
    superellipse,
    tube,
)
from gpu.scene.camera import look_at
from gpu.scene.types import Bytes, Scene

_LONG, _WIDE, _HIGH = 9.0, 6.6, 2.88  # metres: x, z, y; whole ceiling tiles of 0.6 m
_X, _Z = _LONG / 2, _WIDE / 2
_TABLE = 0.74


def make() -> Scene:
    """The room at full detail."""
    builder = Builder("conference-room")
    _shell(builder)
    _ceiling(builder)
    _windows(builder)
    _table(builder)
    _chairs(builder)
    _screen_wall(builder)
    _back_wall(builder)
    return builder.scene(
        [
            look_at((4.05, 1.62, 2.75), (-1.5, 0.8, -0.75), yfov_degrees=52, name="corner"),
            look_at((3.9, 1.45, 0.0), (-4.5, 1.0, 0.0), yfov_degrees=50, name="head of the table"),
            look_at((-3.45, 1.6, -1.7), (2.2, 0.75, 1.25), yfov_degrees=55, name="from the screen"),
        ]
    )


def _shell(builder: Builder) -> None:
    carpet = textures.carpet(1, ["#555b62", "#777d84", "#979ba0"])
    builder.add(builder.textured("carpet", carpet, (1.0, 1.0), 0.95), rooms.level(_X, _Z, 0.0))
    white = builder.textured("plaster", textures.plaster(2, "#e9e5dc", 0.008), (2.0, 2.0), 0.9)
    blue = builder.textured("blue plaster", textures.plaster(3, "#5f7f8c", 0.015), (2.0, 2.0), 0.9)
    felt = builder.paint("felt", "#4b4640", 1.0)
    builder.add(white, Placer(180, (_X, 0, _Z))(rooms.wall(_LONG, _HIGH)))
    builder.add(white, Placer(0, (-_X, 0, -_Z))(rooms.wall(_LONG, _HIGH, _openings(), 0.22)))
    builder.add(blue, Placer(-90, (_X, 0, -_Z))(rooms.wall(_WIDE, _HIGH)))
    builder.add(felt, Placer(90, (-_X, 0, _Z))(rooms.wall(_WIDE, _HIGH)))
    board = builder.paint("skirting", "#d9d5cc", 0.5)
    left, right = 2.25 - 0.53, 2.25 + 0.53  # the door's casing
    plan = [(left, _Z), (-_X, _Z)], [(-_X, -_Z), (_X, -_Z), (_X, _Z), (right, _Z)]
    builder.add(board, rooms.skirting(plan[0][::-1]), rooms.skirting(plan[1]))


def _openings() -> list[Opening]:
    return [Opening(x, 0.82, x + 2.2, 2.42) for x in (0.6, 3.4, 6.2)]


def _ceiling(builder: Builder) -> None:
    tile = builder.textured("ceiling tile", textures.plaster(4, "#ebe9e3", 0.012), (0.6, 0.6), 1.0)
    builder.add(tile, rooms.level(_X, _Z, -_HIGH).mirrored(1))
    metal = builder.paint("ceiling grid", "#e6e6e2", 0.5)
    for number in range(1, 15):
        x = -_X + 0.6 * number
        builder.add(metal, block((x - 0.012, _HIGH - 0.007, -_Z + 0.001), (x + 0.012, _HIGH + 0.001, _Z - 0.001)))
    for number in range(1, 11):
        z = -_Z + 0.6 * number
        builder.add(metal, block((-_X + 0.001, _HIGH - 0.0075, z - 0.012), (_X - 0.001, _HIGH + 0.001, z + 0.012)))

    rim = [(-0.002, -0.022), (-0.002, 0.002), (0.003, 0.003), (0.035, -0.010), (0.035, -0.014), (0.004, -0.022)]
    frame = moulding(rim, rectangle((-0.6, -0.3), (0.6, 0.3)))
    lamp = quad((-0.566, -0.012, -0.266), (1.132, 0, 0), (0, 0, 0.532))
    places = [(x, _HIGH, z) for x in (-2.7, -0.9, 0.9, 2.7) for z in (-1.2, 1.2)]
    builder.add(metal, copies(frame, places))
    builder.add(builder.light("ceiling panel", (8.6, 8.0, 7.0)), copies(lamp, places))

    white = builder.paint("projector", "#e4e3df", 0.4)
    dark = builder.paint("projector lens", "#3c4048", 0.3)
    builder.add(white, box((0.3, 0.11, 0.38), 0.02, 3).moved(-0.9, 2.42, 0), cylinder(0.018, 0.5).moved(-0.9, 2.47, 0))
    builder.add(white, cylinder(0.07, 0.02, 32, 0.004).moved(-0.9, _HIGH - 0.026, 0))
    lens = lathe([(0, 0), (0.045, 0), (0.045, 0.03), (0.036, 0.034), (0.03, 0.024), (0, 0.03)], 32)
    builder.add(dark, lens.turned(90, "z").moved(-1.049, 2.42, 0.06))


def _windows(builder: Builder) -> None:
    to_wall = Placer(0, (-_X, 0, -_Z))
    aluminium = builder.paint("aluminium", "#a9adb0", 0.4)
    slats = builder.paint("blind", "#dcd8ce", 0.6)
    cords = builder.paint("blind cord", "#b7b2a6", 0.8)
    sill = builder.paint("window sill", "#dedad0", 0.4)
    day = builder.light("daylight", (2.5, 3.1, 3.9))
    for hole in _openings():
        builder.add(aluminium, to_wall(rooms.window_frame(hole, -0.16, 2)))
        builder.add(day, to_wall(rooms.pane(hole, 0.22)))
        blind, cord = rooms.venetian_blind(hole, -0.07, 38.0)
        builder.add(slats, to_wall(blind))
        builder.add(cords, to_wall(cord))
        board = box((hole.width + 0.12, 0.03, 0.12), 0.008, 2)
        builder.add(sill, to_wall(board.moved(hole.left + hole.width / 2, hole.bottom - 0.0155, 0.05)))


def _table(builder: Builder) -> None:
    walnut = builder.textured("walnut", textures.wood(5, ["#5a3d2a", "#855c3d", "#a67a53"], 1024), (1.6, 0.8), 0.35)
    black = builder.paint("black steel", "#45464a", 0.4)
    builder.add(walnut, slab(superellipse(2.75, 0.82, 3.0, 160), 0.045, 0.014, 4).moved(0, _TABLE - 0.045, 0))
    for x in (-1.55, 1.55):
        builder.add(black, slab(superellipse(0.2, 0.28, 3.0, 64), 0.6, 0.004).moved(x, 0.05, 0))
        builder.add(black, slab(superellipse(0.38, 0.46, 3.0, 64), 0.05, 0.012).moved(x, 0.0005, 0))
        builder.add(black, slab(superellipse(0.5, 0.5, 3.0, 64), 0.044, 0.004).moved(x, 0.6505, 0))
    beam = box((3.3, 0.12, 0.04), 0.006).moved(0, 0.58, 0)
    builder.add(black, beam)
    _table_things(builder, black)


def _table_things(builder: Builder, black: int) -> None:
    top = _TABLE + 0.0005
    silver = builder.paint("brushed metal", "#b4b7ba", 0.35)
    paper = builder.paint("paper", "#ebe9e2", 0.9)
    china = builder.paint("china", "#eae7df", 0.3)
    blue = builder.paint("blue glaze", "#48698a", 0.3)
    for x in (-0.95, 0.95):
        builder.add(silver, slab(superellipse(0.17, 0.065, 6.0, 64), 0.006, 0.002).moved(x, top, 0))
        builder.add(black, box((0.26, 0.003, 0.08), 0.001).moved(x, top + 0.0072, 0))

    case, screen = furnishings.laptop()
    desks = [(-1.9, top, 0.5), (0.05, top, -0.5), (1.95, top, 0.48)]
    turns = [4.0, 176.0, -7.0]
    builder.add(silver, placed(case, desks, turns))
    builder.add(black, placed(screen, desks, turns))

    sheet = box((0.21, 0.006, 0.297), 0.001)
    pads = [(-1.0, top + 0.003, 0.52), (0.98, top + 0.003, 0.53), (-1.02, top + 0.003, -0.52), (1.1, top + 0.003, -0.5)]
    builder.add(paper, placed(sheet, [*pads, (-1.95, top + 0.003, -0.5)], [3.0, -5.0, 2.0, 8.0, -4.0]))
    pen = tube(
        [(0, 0.0045, -0.07), (0, 0.0045, 0.06), (0, 0.0045, 0.068), (0, 0.0045, 0.074)],
        [0.0045, 0.0045, 0.002, 0.0008],
        12,
    )
    builder.add(black, placed(pen, [(x + 0.04, top + 0.0065, z) for x, _, z in pads], [20.0, -30.0, 200.0, 150.0]))

    cups = [(-1.55, top, 0.42), (0.62, top, 0.5), (1.52, top, 0.4), (-0.62, top, -0.47), (0.45, top, -0.42)]
    builder.add(china, placed(furnishings.saucer(), cups))
    lifted = [(x, y + 0.0065, z) for x, y, z in cups]
    builder.add(china, placed(furnishings.mug(0.036, 0.075), lifted[::2], [30, 200, 130]))
    builder.add(blue, placed(furnishings.mug(0.036, 0.075), lifted[1::2], [280, 80]))

    phone = join([slab(superellipse(0.16, 0.05, 2.5, 64), 0.035, 0.014, 4).turned(angle) for angle in (90, 210, 330)])
    builder.add(black, phone.moved(0.42, top, 0.0))
    bowl, oranges, apples = furnishings.bowl_of_fruit(6)
    builder.add(china, bowl.moved(-0.3, top, 0.02))
    builder.add(builder.paint("orange", "#d9822b", 0.6), oranges.moved(-0.3, top, 0.02))
    builder.add(builder.paint("apple", "#a8362c", 0.4), apples.moved(-0.3, top, 0.02))


def _chair() -> tuple[Shape, Shape, Shape]:
    """A conference chair that faces +Z: (steel, upholstery, arm pads)."""
    wide, low = 0.27, 0.009
    loop = rounded_path(
        [(wide, low, 0.25), (wide, 0.645, 0.215), (wide, 0.655, -0.2), (wide + 0.005, low, -0.29)], 0.075, 14
    )
    side = tube(loop, 0.0085, 20)
    under = rounded_path(
        [(wide, 0.4, 0.228), (wide - 0.04, 0.4, 0.22), (-wide + 0.04, 0.4, 0.22), (-wide, 0.4, 0.228)], 0.03, 8
    )
    behind = rounded_path(
        [(wide, 0.4, -0.245), (wide - 0.04, 0.4, -0.19), (-wide + 0.04, 0.4, -0.19), (-wide, 0.4, -0.245)], 0.03, 8
    )
    spine = rounded_path([(0.13, 0.395, -0.1), (0.13, 0.4, -0.235), (0.13, 0.78, -0.31)], 0.06, 10)
    steel = [side, side.mirrored(0), tube(under, 0.008, 18), tube(behind, 0.008, 18)]
    steel += [tube(spine, 0.008, 18), tube(spine, 0.008, 18).mirrored(0)]
    foot = lathe([(0, 0.0005), (0.011, 0.0005), (0.012, 0.003), (0.011, 0.03), (0, 0.03)], 24)
    steel += [foot.moved(x, 0, z) for x in (wide, -wide) for z in (0.2505, -0.289)]

    flat = box((0.49, 0.065, 0.48), 0.028, 3, 9, 0.006)
    x, z = flat.positions[:, 0] / 0.245, flat.positions[:, 2] / 0.24
    drop = 0.012 * (x * x - 1) * (1 - np.clip(z, 0, 1)) * -1 - 0.03 * np.clip(z - 0.3, 0, 1) ** 2
    seat = warped(flat, flat.positions + np.stack([0 * x, drop, 0 * x], axis=1)).moved(0, 0.441, 0)
    rest = box((0.47, 0.46, 0.042), 0.02, 3, 10)
    u, v = rest.positions[:, 0] / 0.235, rest.positions[:, 1] / 0.23
    curve = 0.045 * u * u - 0.03 * v * v * np.sign(v) * (v > 0)
    narrow = 1.0 - 0.07 * np.clip(v, 0, 1) ** 2
    points = np.stack([rest.positions[:, 0] * narrow, rest.positions[:, 1], rest.positions[:, 2] + curve], axis=1)
    back = warped(rest, points).turned(-11, "x").moved(0, 0.72, -0.262)
    pad = box((0.042, 0.022, 0.29), 0.009, 2, 2).moved(wide, 0.668, 0.0)
    return join(steel), join([seat, back]), join([pad, pad.mirrored(0)])


def _chairs(builder: Builder) -> None:
    rng = np.random.default_rng(7)
    places = [(x, z) for x in (-1.92, -0.96, 0.0, 0.96, 1.92) for z in (1.02, -1.02)] + [(3.08, 0.0), (-3.08, 0.0)]
    degrees = [180.0 if z > 0 else 0.0 for _, z in places[:-2]] + [-90.0, 90.0]
    places += [(x, 2.86) for x in (-3.95, -3.25, -2.55)] + [(4.07, z) for z in (-1.2, -0.4)]
    degrees += [180.0] * 3 + [-90.0] * 2
    steel, cloth, pads = _chair()
    where = np.array([(x, 0.0, z) for x, z in places])
    where[:12, [0, 2]] += rng.normal(0.0, 0.025, (12, 2))
    turn = np.array(degrees)
    turn[:12] += rng.normal(0.0, 7.0, 12)
    turn[4] += 24.0  # somebody has just got up
    where[4, 2] += 0.16
    chrome = builder.paint("chair steel", "#a5a8ab", 0.25)
    weave = textures.fabric(8, ["#6f4434", "#a15f45", "#bd7d60"])
    fabric = builder.textured("upholstery", weave, (0.16, 0.16), 0.95)
    rubber = builder.paint("arm pad", "#44444a", 0.7)
    for material, shape in ((chrome, steel), (fabric, cloth), (rubber, pads)):
        builder.add(material, placed(shape, where.tolist(), turn))


def _screen_wall(builder: Builder) -> None:
    """The wall at −X: battens of oak on felt, a lit-looking chart on a matt screen."""
    oak = builder.textured("oak", textures.wood(9, ["#8a6844", "#b08a60", "#c9a67c"]), (1.0, 0.25), 0.5)
    batten = box((0.024, _HIGH - 0.006, 0.065), 0.004, 2)
    spots = np.arange(-_Z + 0.06, _Z - 0.05, 0.108)
    shifts = np.random.default_rng(10).uniform(0, 1, (len(spots), 2))
    bars = copies(batten.mapped_uv(swap=True), [(-_X + 0.0135, _HIGH / 2, z) for z in spots], uv_shifts=shifts)
    builder.add(oak, bars)
    black = builder.paint("screen frame", "#42434a", 0.4)
    chart = builder.textured("slide", _slide(), (1.0, 1.0), 0.6)
    place = Placer(90, (-_X + 0.06, 1.58, 0.0))
    builder.add(black, place(box((2.36, 1.36, 0.03), 0.006, 2)))
    builder.add(chart, place(picture(2.3, 1.3).moved(0, 0, 0.0155)))


def _slide() -> Bytes:
    """A title, a bar chart and a curve, as a slide of 16:9."""
    v, u = np.mgrid[0:288, 0:512] / np.array([288, 512])[:, None, None]
    page = np.broadcast_to(textures.encoded("#e9ecee"), (288, 512, 3)).copy()
    page[(v < 0.2)] = textures.encoded("#2f5d7c")
    page[(np.abs(v - 0.1) < 0.028) & (u > 0.05) & (u < 0.52) & (np.sin(u * 210) + np.sin(u * 87) > -0.4)] = 0.92
    heights = np.array([0.22, 0.3, 0.27, 0.38, 0.45, 0.58])
    bar = np.clip(((u - 0.07) / 0.075).astype(int), 0, 5)
    inside = ((u - 0.07) % 0.075 < 0.05) & (u > 0.07) & (u < 0.5) & (v < 0.9) & (v > 0.9 - heights[bar])
    page[inside] = textures.encoded("#e0883a")
    page[inside & (bar % 2 == 1)] = textures.encoded("#3f8f8a")
    curve = 0.85 - 0.5 / (1 + np.exp(-(u - 0.77) * 22))
    page[(np.abs(v - curve) < 0.012) & (u > 0.58) & (u < 0.95)] = textures.encoded("#b23a48")
    page[((np.abs(v - 0.9) < 0.004) & ((u < 0.52) | (u > 0.56)) & (u > 0.05) & (u < 0.96))] = textures.encoded(
        "#55606a"
    )
    return textures.image(page)


def _back_wall(builder: Builder) -> None:
    """The walls at +Z and +X: door, sideboard with coffee, pictures, clock, plants."""
    wood = builder.textured("door", textures.wood(11, ["#7d5a3a", "#a27a52", "#bd966c"]), (1.0, 0.25), 0.45)
    casing = builder.paint("door casing", "#d9d5cc", 0.5)
    steel = builder.paint("steel", "#b0b2b4", 0.3)
    at_door = Placer(180, (2.25, 0, _Z - 0.0155))
    leaf, rim, handle = rooms.door(0.9, 2.1)
    builder.add(wood, at_door(leaf.mapped_uv(swap=True)))
    builder.add(casing, at_door(rim.moved(z=-0.006)))
    builder.add(steel, at_door(handle))

    white = builder.paint("sideboard", "#dddad2", 0.4)
    at_board = Placer(180, (-0.2, 0, _Z - 0.25))
    builder.add(white, at_board(box((2.4, 0.66, 0.44), 0.003).moved(0, 0.41, 0)))
    builder.add(wood, at_board(box((2.44, 0.025, 0.47), 0.004, 2).moved(0, 0.753, 0.006)))
    builder.add(
        white, *(at_board(box((0.588, 0.62, 0.018), 0.003).moved(x, 0.41, 0.2295)) for x in (-0.9, -0.3, 0.3, 0.9))
    )
    builder.add(
        steel, *(at_board(box((0.12, 0.01, 0.014), 0.003, 2).moved(x, 0.66, 0.246)) for x in (-0.9, -0.3, 0.3, 0.9))
    )
    builder.add(steel, at_board(box((2.3, 0.079, 0.36), 0.003).moved(0, 0.04, 0)))
    flask = lathe(
        [(0, 0), (0.05, 0), (0.055, 0.005), (0.055, 0.2), (0.035, 0.24), (0.035, 0.27), (0.028, 0.28), (0, 0.28)], 40
    )
    builder.add(steel, *(at_board(flask.moved(x, 0.766, z)) for x, z in ((-0.8, 0.0), (-0.66, 0.05))))
    china = builder.paint("white china", "#ebe8e0", 0.3)
    cups = [(x, 0.766, z) for x in (-0.4, -0.28, -0.16) for z in (-0.06, 0.06)]
    builder.add(china, at_board(placed(furnishings.mug(0.034, 0.07), cups, [20, 70, 120, 40, 160, 90])))

    picture_wood = builder.paint("picture frame", "#4b443d", 0.5)
    pictures = [
        paintings.strata(12, ["#1f4e5f", "#3f8f8a", "#e8dcc0", "#e0a458", "#b5533c"]),
        paintings.blocks(13, ["#e3d9c6", "#d98e4a", "#8c3b2e", "#37526b"]),
    ]
    spots = [Placer(180, (-0.2, 1.62, _Z)), Placer(-90, (_X, 1.55, 1.6))]
    for pixels, (width, height), place in zip(pictures, ((1.5, 0.9), (0.9, 1.15)), spots, strict=True):
        builder.add(picture_wood, place(rooms.picture_frame(width, height)))
        canvas = builder.textured("painting", pixels, roughness=0.8)
        builder.add(canvas, place(picture(width, height).moved(0, 0, 0.01)))
    rim, face, marks = (Placer(-90, (_X, 2.1, -0.8))(part) for part in furnishings.clock(0.17))
    builder.add(steel, rim)
    builder.add(china, face)
    builder.add(picture_wood, marks)

    _plants(builder)


def _plants(builder: Builder) -> None:
    green = builder.textured("fig leaves", textures.leaves(14, ["#35562c", "#5a7f3e", "#93ab66"]), (1.0, 1.0), 0.5)
    bark = builder.paint("bark", "#7c6a52", 0.9)
    earth = builder.paint("soil", "#4d4136", 1.0)
    clay = builder.paint("planter", "#d6d2c8", 0.6)
    for seed, (x, z), tall in ((15, (-3.95, -2.75), 1.9), (16, (3.95, -2.7), 1.7)):
        planter, soil = furnishings.pot(0.22, 0.42)
        stems, foliage = furnishings.tree(seed, tall, 5, 230, 0.4)
        for material, shape in ((clay, planter), (earth, soil), (bark, stems), (green, foliage)):
            builder.add(material, shape.moved(x, 0.0005, z))
