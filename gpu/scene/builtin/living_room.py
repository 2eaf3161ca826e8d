"""A living room in the afternoon: large smooth walls, a wide window, lamps, books and a dining corner."""

import numpy as np

from gpu.scene.builtin import furnishings, paintings, rooms, seating, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.rooms import Opening, Placer
from gpu.scene.builtin.shape import copies, placed
from gpu.scene.builtin.shapes import (
    block,
    box,
    cylinder,
    lathe,
    moulding,
    picture,
    rectangle,
    slab,
    sphere,
    superellipse,
    tube,
)
from gpu.scene.camera import look_at
from gpu.scene.types import Scene

_X, _Z, _HIGH = 3.3, 3.3, 2.75  # half the length, half the width, the height, in metres
_WINDOW = Opening(1.7, 0.12, 5.3, 2.4)


def make() -> Scene:
    """The furnished room."""
    builder = Builder("living-room")
    oak = builder.textured("oak", textures.wood(21, ["#7d5b3a", "#a9825a", "#c6a379"]), (1.2, 0.4), 0.5)
    walnut = builder.textured("walnut", textures.wood(22, ["#4e3727", "#74513a", "#93694a"]), (1.2, 0.4), 0.45)
    brass = builder.paint("brass", "#b08d57", 0.3)
    china = builder.paint("china", "#e6e0d4", 0.35)
    _shell(builder, oak)
    _window(builder, brass)
    _seats(builder, walnut)
    _coffee_table(builder, walnut, china)
    _lamps(builder, walnut, brass, china)
    _bookcase(builder, walnut, china)
    _dining_corner(builder, oak, china)
    _sideboard(builder, walnut, brass, china)
    _pictures(builder, oak)
    _plants(builder)
    return builder.scene(
        [
            look_at((2.3, 1.55, 2.3), (-0.75, 0.92, -1.9), yfov_degrees=54, name="living room"),
            look_at((2.55, 1.6, -2.2), (-1.1, 0.95, 1.7), yfov_degrees=54, name="dining corner"),
            look_at((-2.75, 1.5, 1.25), (1.5, 0.95, -2.2), yfov_degrees=52, name="from the window"),
        ]
    )


def _shell(builder: Builder, oak: int) -> None:
    boards = textures.planks(23, ["#80603f", "#aa855c", "#c9a67b"], 8, 2)
    floor = builder.textured("floorboards", boards, (3.0, 1.12), 0.4)
    builder.add(floor, rooms.level(_X, _Z, 0.0))
    white = builder.textured("plaster", textures.plaster(24, "#ece6da", 0.006), (2.0, 2.0), 0.95)
    sage = builder.textured("sage plaster", textures.plaster(25, "#9aa58c", 0.008), (2.0, 2.0), 0.95)
    trim = builder.paint("white paint", "#e7e2d8", 0.5)
    builder.add(white, rooms.level(_X, _Z, -_HIGH).mirrored(1))
    builder.add(sage, Placer(0, (-_X, 0, -_Z))(rooms.wall(2 * _X, _HIGH)))
    builder.add(white, Placer(90, (-_X, 0, _Z))(rooms.wall(2 * _Z, _HIGH, [_WINDOW], 0.3)))
    builder.add(white, Placer(180, (_X, 0, _Z))(rooms.wall(2 * _X, _HIGH)))
    builder.add(white, Placer(-90, (_X, 0, -_Z))(rooms.wall(2 * _Z, _HIGH)))

    section = [(-0.002, -0.11), (-0.002, 0.002), (0.1, 0.002), (0.1, -0.012), (0.082, -0.02), (0.06, -0.034)]
    section += [(0.042, -0.054), (0.03, -0.08), (0.012, -0.095), (0.012, -0.11)]
    builder.add(trim, moulding(section, rectangle((-_X, -_Z), (_X, _Z))).moved(y=_HIGH))
    left, right = 2.35 - 0.53, 2.35 + 0.53  # the door's casing
    plan = [(right, _Z), (_X, _Z), (_X, -_Z), (-_X, -_Z), (-_X, _Z), (left, _Z)]
    builder.add(trim, rooms.skirting(plan, 0.1))

    at_door = Placer(180, (2.35, 0, _Z - 0.0155))
    leaf, casing, handle = rooms.door(0.9, 2.1)
    builder.add(trim, at_door(leaf), at_door(casing.moved(z=-0.006)))
    builder.add(builder.paint("steel", "#a9a9a6", 0.3), at_door(handle))


def _window(builder: Builder, brass: int) -> None:
    to_wall = Placer(90, (-_X, 0, _Z))
    frame = builder.paint("window frame", "#e6e2d9", 0.5)
    builder.add(frame, to_wall(rooms.window_frame(_WINDOW, -0.22, 3, 1, 0.06, 0.07)))
    board = box((_WINDOW.width + 0.1, 0.03, 0.14), 0.008, 2)
    builder.add(frame, to_wall(board.moved(_WINDOW.left + _WINDOW.width / 2, _WINDOW.bottom - 0.0155, 0.05)))
    _garden(builder, to_wall)
    linen = textures.fabric(26, ["#b9ae9c", "#d3c9b8", "#e2dacb"])
    cloth = builder.textured("linen", linen, (0.2, 0.2), 1.0)
    for seed, middle in ((27, _WINDOW.left - 0.16), (28, _WINDOW.right + 0.16)):
        builder.add(cloth, to_wall(furnishings.curtain(0.72, 2.49, 7.5, 0.045, seed).moved(middle, 0, 0.17)))
    builder.add(brass, to_wall(furnishings.rod(_WINDOW.width + 1.3).moved(_WINDOW.left + _WINDOW.width / 2, 2.5, 0.17)))


def _garden(builder: Builder, to_wall: Placer) -> None:
    """What is seen through the window, as glowing bands: sky over far hills, a hedge and a lawn."""
    x = np.linspace(0.0, 1.0, 241)
    hills = 0.5 + 0.04 * np.sin(4.2 * x + 0.6) + 0.015 * np.sin(11.0 * x)
    lawn = 0.22 + 0.02 * np.sin(3.0 * x)
    hedge = 0.3 + 0.008 * np.sin(61.0 * x) + 0.006 * np.sin(97.0 * x + 2.0)
    crowns = [
        (0.1, 0.3, 0.13),
        (0.2, 0.44, 0.11),
        (0.3, 0.36, 0.1),
        (0.62, 0.26, 0.1),
        (0.8, 0.34, 0.1),
        (0.88, 0.42, 0.09),
    ]
    for middle, height, radius in crowns:
        ragged = radius * (1.0 + 0.05 * np.sin(70.0 * x + 40.0 * middle))
        hedge = np.maximum(hedge, height + 1.4 * np.sqrt(np.maximum(ragged**2 - (x - middle) ** 2, 0.0)))
    hills = np.maximum(hills, hedge + 0.004)
    names = ("lawn", "hedge", "hills", "sky")
    glows = ((1.3, 1.8, 0.6), (0.4, 0.7, 0.25), (2.4, 3.2, 3.4), (9.5, 10.8, 12.6))
    bands = rooms.bands(_WINDOW, 0.3, [lawn, hedge, hills])
    for name, glow, band in zip(names, glows, bands, strict=True):
        builder.add(builder.light(name, glow), to_wall(band))


def _seats(builder: Builder, walnut: int) -> None:
    grey = textures.fabric(29, ["#76736e", "#a19d96", "#bdb9b0"])
    wool = builder.textured("grey wool", grey, (0.14, 0.14), 1.0)
    body, legs = seating.sofa(2.35, 3)
    builder.add(wool, body.moved(-0.35, 0, -2.74))
    builder.add(walnut, legs.moved(-0.35, 0, -2.74))
    mustard = builder.textured("mustard", textures.fabric(30, ["#97702c", "#c3953f", "#d6ac5c"]), (0.12, 0.12), 1.0)
    rust = builder.textured("rust", textures.fabric(31, ["#7c402b", "#a95b3f", "#c0765a"]), (0.12, 0.12), 1.0)
    builder.add(
        mustard, seating.scatter([(-1.12, 0.72, -2.61)], [8.0]), seating.scatter([(0.44, 0.7, -2.6)], [-14.0], 0.4)
    )
    builder.add(rust, seating.scatter([(-0.78, 0.69, -2.53)], [-10.0], 0.38))

    teal = builder.textured("teal wool", textures.fabric(32, ["#31524f", "#4a7470", "#658f8a"]), (0.14, 0.14), 1.0)
    chair, feet = seating.sofa(0.98, 1, 0.86)
    builder.add(teal, placed(chair, [(-2.3, 0, -1.0)], 104.0))
    builder.add(walnut, placed(feet, [(-2.3, 0, -1.0)], 104.0))
    builder.add(rust, placed(seating.scatter([(0.0, 0.68, -0.16)], [6.0], 0.4), [(-2.3, 0, -1.0)], 104.0))
    knit = builder.textured("knit", textures.fabric(33, ["#a3937c", "#c6b79f", "#d9ccb6"]), (0.25, 0.25), 1.0)
    builder.add(knit, seating.pouf(0.29, 0.38).moved(1.25, 0.013, -1.0))


def _coffee_table(builder: Builder, walnut: int, china: int) -> None:
    pattern = textures.kilim(34, ["#c9b795", "#8f4a37", "#d9cdb4", "#3f5a66", "#b5784a"])
    rug = builder.textured("rug", pattern, (3.0, 2.1), 1.0)
    builder.add(rug, box((3.0, 0.012, 2.1), 0.004).mapped_uv(1.5, 1.05).moved(-0.35, 0.0065, -1.3))
    x, z, top = -0.45, -1.4, 0.4
    plate, legs = seating.stool_table(0.48, top - 0.013, 0.034)
    builder.add(walnut, plate.moved(x, 0.013, z), legs.moved(x, 0.009, z))
    top += 0.0005
    cloths = [builder.paint("book cloth", colour, 0.8) for colour in ("#3d5a73", "#b0603f", "#d8c9a8")]
    sheets = builder.paint("book pages", "#e6dfcd", 0.9)
    for number, (cloth, size, angle) in enumerate(zip(cloths, (0.3, 0.27, 0.22), (12.0, 20.0, -8.0), strict=True)):
        y = top + 0.0275 * number
        cover = [block((-size / 2, low, -size * 0.36), (size / 2, low + 0.003, size * 0.36)) for low in (0.0, 0.024)]
        pages = block((-size / 2 + 0.004, 0.0035, -size * 0.35), (size / 2 - 0.002, 0.0235, size * 0.35))
        spine = block((-size / 2, 0.0035, -size * 0.36), (-size / 2 + 0.003, 0.0235, size * 0.36))
        place = Placer(angle, (x - 0.17, y, z + 0.12))
        builder.add(cloth, *(place(part) for part in (*cover, spine)))
        builder.add(sheets, place(pages))
    bowl, oranges, apples = furnishings.bowl_of_fruit(35)
    builder.add(china, bowl.moved(x + 0.17, top, z - 0.1))
    builder.add(builder.paint("orange", "#d68a35", 0.6), oranges.moved(x + 0.17, top, z - 0.1))
    builder.add(builder.paint("apple", "#9db04a", 0.4), apples.moved(x + 0.17, top, z - 0.1))
    builder.add(china, placed(furnishings.mug(), [(x + 0.12, top, z + 0.25)], 40.0))


def _lamps(builder: Builder, walnut: int, brass: int, china: int) -> None:
    shade = builder.light("lamp shade", (3.8, 2.6, 1.4))
    lining = builder.light("shade lining", (12.0, 8.0, 4.2))
    builder.add(brass, seating.floor_lamp(1.5).moved(1.22, 0, -2.78))
    cover, inner = furnishings.drum_shade(0.22, 0.3)
    builder.add(shade, cover.moved(1.22, 1.38, -2.78))
    builder.add(lining, inner.moved(1.22, 1.38, -2.78))

    plate, legs = seating.stool_table(0.24, 0.5, 0.026)
    builder.add(walnut, plate.moved(-1.9, 0, -2.85), legs.moved(-1.9, 0, -2.85))
    cover, inner = furnishings.drum_shade(0.17, 0.2, 0.8)
    for x, y, z in ((-1.9, 0.5, -2.85), (3.02, 0.7605, 0.55)):
        body = furnishings.vase(0.085, 0.26).moved(x, y + 0.0005, z)
        builder.add(china, body)
        builder.add(brass, cylinder(0.008, 0.16, 16).moved(x, y + 0.22, z))
        builder.add(shade, cover.moved(x, y + 0.33, z))
        builder.add(lining, inner.moved(x, y + 0.33, z))

    dome, inside = seating.pendant(1.15)
    x, z = -0.9, 1.95
    builder.add(builder.paint("lamp enamel", "#3f5a55", 0.35), dome.moved(x, _HIGH, z))
    builder.add(builder.paint("lamp inside", "#ece8de", 0.8), inside.moved(x, _HIGH, z))
    bulb = builder.light("bulb", (45.0, 30.0, 16.0))
    builder.add(bulb, sphere(0.06, 24).moved(x, _HIGH - 1.08, z))


def _bookcase(builder: Builder, walnut: int, china: int) -> None:
    spines = textures.book_spines(
        36, ["#7b3b2e", "#2f4a5a", "#4d5a3c", "#a5803f", "#5c3a4a", "#c9b791", "#3c4644", "#8e5a3a"]
    )
    cloth = builder.textured("book spines", spines, (1.0, 1.0), 0.8)
    pages = builder.paint("pages", "#ddd5c2", 0.9)
    wide, tall, deep, board = 1.4, 2.16, 0.3, 0.025
    place = Placer(0, (2.35, 0.0005, -_Z + 0.0165))
    half = wide / 2
    builder.add(walnut, place(block((-half, 0, 0), (-half + board, tall, deep)).mapped_uv(swap=True)))
    builder.add(walnut, place(block((half - board, 0, 0), (half, tall, deep)).mapped_uv(swap=True)))
    builder.add(walnut, place(block((-half + board, 0.06, 0.0005), (half - board, tall - 0.0005, 0.012))))
    levels = [0.06, 0.43, 0.79, 1.13, 1.47, 1.81, tall - board - 0.0005]
    inner = half - board - 0.0005
    builder.add(walnut, *(place(block((-inner, y, 0.0125), (inner, y + board, deep - 0.004))) for y in levels))
    # Rows of books on each shelf: where they begin and how long they are.
    rows = [
        [(-0.66, 1.3)],
        [(-0.66, 0.55), (0.16, 0.5)],
        [(-0.64, 1.0)],
        [(-0.3, 0.96)],
        [(-0.66, 0.72)],
        [(-0.66, 0.4), (0.2, 0.45)],
    ]
    for shelf, (level, spans) in enumerate(zip(levels, rows, strict=False)):
        gap = levels[shelf + 1] - level - board
        for number, (start, length) in enumerate(spans):
            covers, paper = furnishings.books(40 + 7 * shelf + number, length, gap * 0.86, 0.22)
            at = (start, level + board + 0.0005, deep - 0.035)
            builder.add(cloth, place(covers.moved(*at)))
            builder.add(pages, place(paper.moved(*at)))
    blue = builder.paint("blue glaze", "#56788c", 0.3)
    on = [level + board + 0.0005 for level in levels]
    builder.add(blue, place(furnishings.vase(0.075, 0.24).moved(0.0, on[1], 0.15)))
    builder.add(china, place(furnishings.vase(0.09, 0.2).moved(0.5, on[2], 0.16)))
    builder.add(china, place(furnishings.vase(0.06, 0.26).moved(-0.5, on[3], 0.16)))
    builder.add(blue, place(sphere(0.07, 40).moved(0.3, on[4] + 0.07, 0.16)))
    builder.add(china, place(furnishings.vase(0.07, 0.19).moved(-0.03, on[5], 0.16)))


def _dining_corner(builder: Builder, oak: int, china: int) -> None:
    x, z, high = -0.9, 1.95, 0.74
    builder.add(oak, slab(superellipse(0.88, 0.46, 5.0, 128), 0.034, 0.011, 3).moved(x, high - 0.034, z))
    legs = [
        tube([(sx * 0.76, 0.003, sz * 0.34), (sx * 0.68, high - 0.03, sz * 0.28)], [0.019, 0.032], 20)
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]
    builder.add(oak, *(leg.moved(x, 0, z) for leg in legs))
    apron = [box((1.3, 0.07, 0.022), 0.003).moved(x, high - 0.0695, z + side * 0.275) for side in (-1, 1)]
    builder.add(oak, *apron)
    wood, pad = seating.wooden_chair()
    places = [(x - 0.38, 0, z - 0.58), (x + 0.4, 0, z - 0.66), (x - 0.4, 0, z + 0.6), (x + 0.36, 0, z + 0.58)]
    turns = [4.0, -12.0, 177.0, 184.0]
    builder.add(builder.paint("black chair", "#46464a", 0.5), placed(wood, places, turns))
    builder.add(
        builder.textured("seat pad", textures.fabric(50, ["#9a8a70", "#bfae92", "#d3c5ac"]), (0.12, 0.12), 1.0),
        placed(pad, places, turns),
    )
    top = high + 0.0005
    plates = [
        (px, top, pz) for px, pz in ((x - 0.4, z - 0.27), (x + 0.4, z - 0.27), (x - 0.4, z + 0.27), (x + 0.4, z + 0.27))
    ]
    builder.add(
        china,
        placed(furnishings.saucer(0.13), plates),
        placed(furnishings.saucer(0.09), [(px, y + 0.0095, pz) for px, y, pz in plates]),
    )
    glaze = builder.paint("green glaze", "#5f7a5a", 0.3)
    builder.add(glaze, furnishings.vase(0.09, 0.24).moved(x, top, z))
    stems, foliage = furnishings.tree(51, 0.48, 5, 26, 0.2)
    builder.add(builder.paint("twigs", "#6f5b45", 0.9), stems.moved(x, top, z))
    builder.add(
        builder.textured("twig leaves", textures.leaves(52, ["#56683f", "#82955c", "#aebb86"]), (1.0, 1.0), 0.6),
        foliage.moved(x, top, z),
    )
    builder.add(
        china,
        placed(furnishings.mug(0.036, 0.08), [(x - 0.16, top, z - 0.22), (x + 0.62, top, z - 0.12)], [70.0, 200.0]),
    )


def _sideboard(builder: Builder, walnut: int, brass: int, china: int) -> None:
    place = Placer(-90, (_X - 0.235, 0, 0.1))
    body = box((1.7, 0.5, 0.42), 0.006, 2).moved(0, 0.51, 0)
    builder.add(walnut, place(body))
    doors = [box((0.548, 0.462, 0.016), 0.003).moved(sx * 0.555, 0.51, 0.2105) for sx in (-1, 0, 1)]
    builder.add(walnut, *(place(door.mapped_uv(0.37 * n, 0.11 * n, swap=True)) for n, door in enumerate(doors)))
    builder.add(brass, *(place(sphere(0.012, 20).moved(sx * 0.555 + 0.22, 0.6, 0.226)) for sx in (-1, 0, 1)))
    leg = furnishings.tapered_leg(0.27, 0.02, 0.012)
    builder.add(walnut, *(place(leg.moved(sx * 0.72, 0, sz * 0.14)) for sx in (-1, 1) for sz in (-1, 1)))
    builder.add(china, place(furnishings.vase(0.1, 0.34).moved(-0.6, 0.7605, 0.0)))
    dish = lathe([(0, 0.003), (0.1, 0.0), (0.17, 0.035), (0.166, 0.037), (0.1, 0.006), (0, 0.008)], 48)
    builder.add(brass, place(dish.moved(-0.05, 0.7605, 0.03)))


def _pictures(builder: Builder, oak: int) -> None:
    black = builder.paint("picture frame", "#4a453f", 0.5)
    hills = paintings.landscape(53, ["#7fa3b5", "#c9d3c4", "#efd9ae"], ["#a9b3a6", "#7f957f", "#58755f", "#3f5848"])
    fields = paintings.blocks(54, ["#e5d9c2", "#c98a4b", "#7c3f34", "#2f4858"])
    bands = paintings.strata(55, ["#294c60", "#7fa1a0", "#eadfc8", "#d9a566", "#a5563c"])
    dunes = paintings.landscape(56, ["#d7a98c", "#ecd2b0", "#f3e4c4"], ["#c9a58a", "#a97d64", "#7d5a4d"])
    hung = [
        (hills, 1.5, 0.95, oak, Placer(0, (-0.35, 1.68, -_Z))),
        (bands, 1.3, 0.85, black, Placer(180, (-0.9, 1.6, _Z))),
        (fields, 0.8, 1.0, black, Placer(-90, (_X, 1.72, 0.1))),
        (dunes, 0.6, 0.75, oak, Placer(180, (0.75, 1.6, _Z))),
    ]
    for pixels, width, height, frame, place in hung:
        builder.add(frame, place(rooms.picture_frame(width, height)))
        canvas = builder.textured("painting", pixels, roughness=0.8)
        builder.add(canvas, place(picture(width, height).moved(0, 0, 0.01)))


def _plants(builder: Builder) -> None:
    green = builder.textured("fig leaves", textures.leaves(57, ["#385830", "#5d8243", "#97ae6c"]), (1.0, 1.0), 0.5)
    bark = builder.paint("bark", "#7c6a52", 0.9)
    earth = builder.paint("soil", "#4d4136", 1.0)
    clay = builder.paint("terracotta", "#b5714f", 0.9)
    for seed, (x, z), tall in ((58, (-2.82, -2.75), 1.95), (59, (-2.85, 2.8), 1.6)):
        planter, soil = furnishings.pot(0.21, 0.4)
        stems, foliage = furnishings.tree(seed, tall, 5, 220, 0.38)
        for material, shape in ((clay, planter), (earth, soil), (bark, stems), (green, foliage)):
            builder.add(material, copies(shape, [(x, 0.0005, z)]))
