"""A conference room in daylight: a long table, thin-legged chairs, ceiling panels, venetian blinds."""

from functools import partial

import numpy as np

from gpu.scene.builtin import paintings, rooms, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.furnishings import bowl_of_fruit, clock, laptop, mug, pot, saucer, tree
from gpu.scene.builtin.rooms import Opening
from gpu.scene.builtin.shape import Shape, join, warped
from gpu.scene.builtin.shapes import (
    block,
    box,
    cylinder,
    lathe,
    moulding,
    picture,
    points,
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
_OPENINGS = [Opening(x, 0.82, x + 2.2, 2.42) for x in (0.6, 3.4, 6.2)]


def make() -> Scene:
    """The room at full detail."""
    builder = Builder("conference-room")
    for part in (_shell, _ceiling, _windows, _table, _table_things, _chairs, _screen_wall, _back_wall, _plants):
        part(builder)
    return builder.scene(
        [
            look_at((4.05, 1.62, 2.75), (-1.5, 0.8, -0.75), yfov_degrees=52, name="corner"),
            look_at((3.9, 1.45, 0.0), (-4.5, 1.0, 0.0), yfov_degrees=50, name="head of the table"),
            look_at((-3.45, 1.6, -1.7), (2.2, 0.75, 1.25), yfov_degrees=55, name="from the screen"),
        ]
    )


def _shell(builder: Builder) -> None:
    builder.textured("carpet", partial(textures.carpet, 1, "#555b62 #777d84 #979ba0"), (1.0, 1.0), 0.95)
    builder.textured("plaster", partial(textures.plaster, 2, "#e9e5dc", 0.008), (2.0, 2.0), 0.9)
    builder.textured("blue plaster", partial(textures.plaster, 3, "#5f7f8c", 0.015), (2.0, 2.0), 0.9)
    builder.paints("felt #4b4640 1.0, skirting #d9d5cc 0.5")
    builder.add("carpet", rooms.level(_X, _Z, 0.0))
    builder.frame(180, (_X, 0, _Z)).add("plaster", rooms.wall(_LONG, _HIGH))
    builder.frame(0, (-_X, 0, -_Z)).add("plaster", rooms.wall(_LONG, _HIGH, _OPENINGS, 0.22))
    builder.frame(-90, (_X, 0, -_Z)).add("blue plaster", rooms.wall(_WIDE, _HIGH))
    builder.frame(90, (-_X, 0, _Z)).add("felt", rooms.wall(_WIDE, _HIGH))
    left, right = 2.25 - 0.53, 2.25 + 0.53  # the door's casing
    plans = [(-_X, _Z), (left, _Z)], [(-_X, -_Z), (_X, -_Z), (_X, _Z), (right, _Z)]
    builder.add("skirting", [rooms.skirting(plan, 0.09) for plan in plans])


def _ceiling(builder: Builder) -> None:
    builder.textured("ceiling tile", partial(textures.plaster, 4, "#ebe9e3", 0.012), (0.6, 0.6), 1.0)
    builder.paints("ceiling grid #e6e6e2 0.5")
    builder.light("ceiling panel", (8.6, 8.0, 7.0))
    builder.paints("projector #e4e3df 0.4, projector lens #3c4048 0.3")
    builder.add("ceiling tile", rooms.level(_X, _Z, -_HIGH).mirrored(1))
    low, high, x_end, z_end = _HIGH - 0.007, _HIGH + 0.001, _X - 0.001, _Z - 0.001
    for x in (-_X + 0.6 * number for number in range(1, 15)):
        builder.add("ceiling grid", block((x - 0.012, low, -z_end), (x + 0.012, high, z_end)))
    for z in (-_Z + 0.6 * number for number in range(1, 11)):
        builder.add("ceiling grid", block((-x_end, low - 0.0005, z - 0.012), (x_end, high, z + 0.012)))

    rim = points("-.002,-.022 -.002,.002 .003,.003 .035,-.01 .035,-.014 .004,-.022")
    frame = moulding(rim, rectangle((-0.6, -0.3), (0.6, 0.3)))
    lamp = quad((-0.566, -0.012, -0.266), (1.132, 0, 0), (0, 0, 0.532))
    places = [(x, _HIGH, z) for x in (-2.7, -0.9, 0.9, 2.7) for z in (-1.2, 1.2)]
    builder.add("ceiling grid, ceiling panel", (frame, lamp), places)

    builder.add("projector", box((0.3, 0.11, 0.38), 0.02, 3).moved(-0.9, 2.42, 0))
    builder.add("projector", cylinder(0.018, 0.5).moved(-0.9, 2.47, 0))
    builder.add("projector", cylinder(0.07, 0.02, 32, 0.004).moved(-0.9, _HIGH - 0.026, 0))
    lens = lathe(points("0,0 .045,0 .045,.03 .036,.034 .03,.024 0,.03"), 32)
    builder.add("projector lens", lens.turned(90, "z").moved(-1.049, 2.42, 0.06))


def _windows(builder: Builder) -> None:
    builder.paints("aluminium #a9adb0 0.4, blind #dcd8ce 0.6, blind cord #b7b2a6 0.8, window sill #dedad0 0.4")
    builder.light("daylight", (2.5, 3.1, 3.9))
    wall = builder.frame(0, (-_X, 0, -_Z))
    for hole in _OPENINGS:
        wall.add("aluminium", rooms.window_frame(hole, -0.16, 2))
        wall.add("daylight", rooms.bands(hole, 0.22, []))
        wall.add("blind, blind cord", rooms.venetian_blind(hole, -0.07, 38.0))
        wall.add("window sill", rooms.sill(hole, 0.12, 0.12))


def _table(builder: Builder) -> None:
    builder.textured("walnut", partial(textures.wood, 5, "#5a3d2a #855c3d #a67a53", 1024), (1.6, 0.8), 0.35)
    builder.paints("black steel #45464a 0.4")
    builder.add("walnut", slab(superellipse(2.75, 0.82, 3.0, 160), 0.045, 0.014, 4).moved(0, _TABLE - 0.045, 0))
    for x in (-1.55, 1.55):
        builder.add("black steel", slab(superellipse(0.2, 0.28, 3.0), 0.6, 0.004).moved(x, 0.05, 0))
        builder.add("black steel", slab(superellipse(0.38, 0.46, 3.0), 0.05, 0.012).moved(x, 0.0005, 0))
        builder.add("black steel", slab(superellipse(0.5, 0.5, 3.0), 0.044, 0.004).moved(x, 0.6505, 0))
    builder.add("black steel", box((3.3, 0.12, 0.04), 0.006).moved(0, 0.58, 0))


def _table_things(builder: Builder) -> None:
    builder.paints("brushed metal #b4b7ba 0.35, paper #ebe9e2 0.9, china #eae7df 0.3, blue glaze #48698a 0.3")
    builder.paints("orange #d9822b 0.6, apple #a8362c 0.4")
    top = _TABLE + 0.0005
    hub = slab(superellipse(0.17, 0.065, 6.0), 0.006, 0.002)
    cover = box((0.26, 0.003, 0.08), 0.001)
    for x in (-0.95, 0.95):
        builder.add("brushed metal", hub.moved(x, top, 0))
        builder.add("black steel", cover.moved(x, top + 0.0072, 0))
    desks = [(-1.9, top, 0.5), (0.05, top, -0.5), (1.95, top, 0.48)]
    builder.add("brushed metal, black steel", laptop(), desks, [4.0, 176.0, -7.0])

    pads = [(-1.0, 0.52), (0.98, 0.53), (-1.02, -0.52), (1.1, -0.5), (-1.95, -0.5)]
    sheets = [(x, top + 0.003, z) for x, z in pads]
    builder.add("paper", box((0.21, 0.006, 0.297), 0.001), sheets, [3.0, -5.0, 2.0, 8.0, -4.0])
    line = points("0,.0045,-.07 0,.0045,.06 0,.0045,.068 0,.0045,.074")
    pens = [(x + 0.04, top + 0.0065, z) for x, z in pads[:4]]
    builder.add("black steel", tube(line, [0.0045, 0.0045, 0.002, 0.0008], 12), pens, [20.0, -30.0, 200.0, 150.0])

    cups = np.array([(-1.55, top, 0.42), (0.62, top, 0.5), (1.52, top, 0.4), (-0.62, top, -0.47), (0.45, top, -0.42)])
    builder.add("china", saucer(), cups)
    on_saucer = np.array([0, 0.0065, 0])
    builder.add("china", mug(0.036, 0.075), cups[::2] + on_saucer, [30, 200, 130])
    builder.add("blue glaze", mug(0.036, 0.075), cups[1::2] + on_saucer, [280, 80])

    phone = slab(superellipse(0.16, 0.05, 2.5), 0.035, 0.014, 4)
    builder.add("black steel", [phone.turned(angle).moved(0.42, top, 0.0) for angle in (90, 210, 330)])
    builder.add("china, orange, apple", bowl_of_fruit(6), (-0.3, top, 0.02))


def _chair() -> tuple[Shape, Shape, Shape]:
    """A conference chair that faces +Z: (steel, upholstery, arm pads)."""
    corners = points(".27,.009,.25 .27,.645,.215 .27,.655,-.2 .275,.009,-.29")
    side = tube(rounded_path(corners, 0.075, 14), 0.0085, 20)
    bars = [
        tube(rounded_path([(0.27, 0.4, z), (0.23, 0.4, m), (-0.23, 0.4, m), (-0.27, 0.4, z)], 0.03, 8), 0.008, 18)
        for z, m in ((0.228, 0.22), (-0.245, -0.19))
    ]
    spine = tube(rounded_path(points(".13,.395,-.1 .13,.4,-.235 .13,.78,-.31"), 0.06, 10), 0.008, 18)
    foot = lathe(points("0,.0005 .011,.0005 .012,.003 .011,.03 0,.03"), 24)
    feet = [foot.moved(x, 0, z) for x in (0.27, -0.27) for z in (0.2505, -0.289)]
    steel = join([side, side.mirrored(0), *bars, spine, spine.mirrored(0), *feet])

    flat = box((0.49, 0.065, 0.48), 0.028, 3, 9, 0.006)
    x, z = flat.positions[:, 0] / 0.245, flat.positions[:, 2] / 0.24
    drop = 0.012 * (x * x - 1) * (1 - np.clip(z, 0, 1)) * -1 - 0.03 * np.clip(z - 0.3, 0, 1) ** 2
    seat = warped(flat, flat.positions + np.stack([0 * x, drop, 0 * x], axis=1)).moved(0, 0.441, 0)
    rest = box((0.47, 0.46, 0.042), 0.02, 3, 10)
    u, v = rest.positions[:, 0] / 0.235, rest.positions[:, 1] / 0.23
    curve = 0.045 * u * u - 0.03 * v * v * np.sign(v) * (v > 0)
    narrow = 1.0 - 0.07 * np.clip(v, 0, 1) ** 2
    bent = np.stack([rest.positions[:, 0] * narrow, rest.positions[:, 1], rest.positions[:, 2] + curve], axis=1)
    back = warped(rest, bent).turned(-11, "x").moved(0, 0.72, -0.262)
    pad = box((0.042, 0.022, 0.29), 0.009, 2, 2).moved(0.27, 0.668, 0.0)
    return steel, join([seat, back]), join([pad, pad.mirrored(0)])


def _chairs(builder: Builder) -> None:
    builder.paints("chair steel #a5a8ab 0.25")
    builder.textured("upholstery", partial(textures.fabric, 8, "#6f4434 #a15f45 #bd7d60"), (0.16, 0.16), 0.95)
    builder.paints("arm pad #44444a 0.7")
    rng = np.random.default_rng(7)
    table = [(x, 0.0, z) for x in (-1.92, -0.96, 0.0, 0.96, 1.92) for z in (1.02, -1.02)]
    ends, walls = points("3.08,0,0 -3.08,0,0"), points("-3.95,0,2.86 -3.25,0,2.86 -2.55,0,2.86 4.07,0,-1.2 4.07,0,-.4")
    where = np.array([*table, *ends, *walls])
    where[:12, [0, 2]] += rng.normal(0.0, 0.025, (12, 2))
    turn = np.array([180.0, 0.0] * 5 + [-90.0, 90.0] + [180.0] * 3 + [-90.0] * 2)
    turn[:12] += rng.normal(0.0, 7.0, 12)
    turn[4] += 24.0  # somebody has just got up
    where[4, 2] += 0.16
    builder.add("chair steel, upholstery, arm pad", _chair(), where, turn)


def _screen_wall(builder: Builder) -> None:
    """The wall at −X: battens of oak on felt, a lit-looking chart on a matt screen."""
    builder.textured("oak", partial(textures.wood, 9, "#8a6844 #b08a60 #c9a67c"), (1.0, 0.25), 0.5)
    builder.paints("screen frame #42434a 0.4")
    builder.textured("slide", _slide, (1.0, 1.0), 0.6)
    batten = box((0.024, _HIGH - 0.006, 0.065), 0.004, 2).mapped_uv(swap=True)
    spots = [(-_X + 0.0135, _HIGH / 2, z) for z in np.arange(-_Z + 0.06, _Z - 0.05, 0.108)]
    shifts = np.random.default_rng(10).uniform(0, 1, (len(spots), 2))
    builder.add("oak", batten.at(spots, uv_shifts=shifts))
    screen = (box((2.36, 1.36, 0.03), 0.006, 2), picture(2.3, 1.3, 0.0155))
    builder.frame(90, (-_X + 0.06, 1.58, 0.0)).add("screen frame, slide", screen)


def _slide() -> Bytes:
    """A title, a bar chart and a curve, as a slide of 16:9."""
    paper, blue, orange, teal, red, grey = textures.palette("#e9ecee #2f5d7c #e0883a #3f8f8a #b23a48 #55606a")
    v, u = np.mgrid[0:288, 0:512] / np.array([288, 512])[:, None, None]
    page = np.broadcast_to(paper, (288, 512, 3)).copy()
    page[(v < 0.2)] = blue
    page[(np.abs(v - 0.1) < 0.028) & (u > 0.05) & (u < 0.52) & (np.sin(u * 210) + np.sin(u * 87) > -0.4)] = 0.92
    heights = np.array([0.22, 0.3, 0.27, 0.38, 0.45, 0.58])
    bar = np.clip(((u - 0.07) / 0.075).astype(int), 0, 5)
    inside = ((u - 0.07) % 0.075 < 0.05) & (u > 0.07) & (u < 0.5) & (v < 0.9) & (v > 0.9 - heights[bar])
    page[inside] = orange
    page[inside & (bar % 2 == 1)] = teal
    curve = 0.85 - 0.5 / (1 + np.exp(-(u - 0.77) * 22))
    page[(np.abs(v - curve) < 0.012) & (u > 0.58) & (u < 0.95)] = red
    page[((np.abs(v - 0.9) < 0.004) & ((u < 0.52) | (u > 0.56)) & (u > 0.05) & (u < 0.96))] = grey
    return textures.image(page)


def _back_wall(builder: Builder) -> None:
    """The walls at +Z and +X: door, sideboard with coffee, pictures, clock."""
    builder.textured("door", partial(textures.wood, 11, "#7d5a3a #a27a52 #bd966c"), (1.0, 0.25), 0.45)
    builder.paints("door casing #d9d5cc 0.5, steel #b0b2b4 0.3, sideboard #dddad2 0.4, white china #ebe8e0 0.3")
    builder.paints("picture frame #4b443d 0.5")
    leaf, rim, handle = rooms.door(0.9, 2.1)
    at_door = builder.frame(180, (2.25, 0, _Z - 0.0155))
    at_door.add("door, door casing, steel", (leaf.mapped_uv(swap=True), rim.moved(z=-0.006), handle))

    board = builder.frame(180, (-0.2, 0, _Z - 0.25))
    board.add("sideboard", box((2.4, 0.66, 0.44), 0.003).moved(0, 0.41, 0))
    board.add("door", box((2.44, 0.025, 0.47), 0.004, 2).moved(0, 0.753, 0.006))
    xs = (-0.9, -0.3, 0.3, 0.9)
    board.add("sideboard", [box((0.588, 0.62, 0.018), 0.003).moved(x, 0.41, 0.2295) for x in xs])
    board.add("steel", [box((0.12, 0.01, 0.014), 0.003, 2).moved(x, 0.66, 0.246) for x in xs])
    board.add("steel", box((2.3, 0.079, 0.36), 0.003).moved(0, 0.04, 0))
    flask = lathe(points("0,0 .05,0 .055,.005 .055,.2 .035,.24 .035,.27 .028,.28 0,.28"), 40)
    board.add("steel", [flask.moved(-0.8, 0.766, 0.0), flask.moved(-0.66, 0.766, 0.05)])
    cups = [(x, 0.766, z) for x in (-0.4, -0.28, -0.16) for z in (-0.06, 0.06)]
    board.add("white china", mug(0.034, 0.07), cups, [20, 70, 120, 40, 160, 90])

    waves = partial(paintings.strata, 12, "#1f4e5f #3f8f8a #e8dcc0 #e0a458 #b5533c")
    fields = partial(paintings.blocks, 13, "#e3d9c6 #d98e4a #8c3b2e #37526b")
    rooms.hang(builder.frame(180, (-0.2, 1.62, _Z)), "picture frame", waves, 1.5, 0.9)
    rooms.hang(builder.frame(-90, (_X, 1.55, 1.6)), "picture frame", fields, 0.9, 1.15)
    builder.frame(-90, (_X, 2.1, -0.8)).add("steel, white china, picture frame", clock(0.17))


def _plants(builder: Builder) -> None:
    builder.textured("fig leaves", partial(textures.leaves, 14, "#35562c #5a7f3e #93ab66"), (1.0, 1.0), 0.5)
    builder.paints("bark #7c6a52 0.9, soil #4d4136 1.0, planter #d6d2c8 0.6")
    for seed, x, z, tall in ((15, -3.95, -2.75, 1.9), (16, 3.95, -2.7, 1.7)):
        fig = (*pot(0.22, 0.42), *tree(seed, tall, 230, 0.4))
        builder.add("planter, soil, bark, fig leaves", fig, (x, 0.0005, z))
