"""A living room in the afternoon: large smooth walls, a wide window, lamps, books and a dining corner."""

from functools import partial

import numpy as np

from gpu.scene.builtin import furnishings, paintings, rooms, seating, textures
from gpu.scene.builtin.builder import Builder
from gpu.scene.builtin.furnishings import mug, pot, saucer, tree, vase
from gpu.scene.builtin.shapes import (
    block,
    box,
    cylinder,
    lathe,
    moulding,
    points,
    rectangle,
    slab,
    sphere,
    superellipse,
    tube,
)
from gpu.scene.camera import look_at
from gpu.scene.types import Scene

_X, _Z, _HIGH = 3.3, 3.3, 2.75  # half the length, half the width, the height, in metres
_WINDOW = rooms.Opening(1.7, 0.12, 5.3, 2.4)


def make() -> Scene:
    """The furnished room."""
    builder = Builder("living-room")
    builder.textured("oak", partial(textures.wood, 21, "#7d5b3a #a9825a #c6a379"), (1.2, 0.4), 0.5)
    builder.textured("walnut", partial(textures.wood, 22, "#4e3727 #74513a #93694a"), (1.2, 0.4), 0.45)
    builder.paints("brass #b08d57 0.3, china #e6e0d4 0.35")
    for part in (_shell, _window, _seats, _coffee_table, _lamps, _bookcase, _dining, _sideboard, _pictures, _plants):
        part(builder)
    return builder.scene(
        [
            look_at((2.3, 1.55, 2.3), (-0.75, 0.92, -1.9), yfov_degrees=54, name="living room"),
            look_at((2.55, 1.6, -2.2), (-1.1, 0.95, 1.7), yfov_degrees=54, name="dining corner"),
            look_at((-2.75, 1.5, 1.25), (1.5, 0.95, -2.2), yfov_degrees=52, name="from the window"),
        ]
    )


def _shell(builder: Builder) -> None:
    builder.textured("floorboards", partial(textures.planks, 23, "#80603f #aa855c #c9a67b"), (3.0, 1.12), 0.4)
    builder.textured("plaster", partial(textures.plaster, 24, "#ece6da", 0.006), (2.0, 2.0), 0.95)
    builder.textured("sage plaster", partial(textures.plaster, 25, "#9aa58c", 0.008), (2.0, 2.0), 0.95)
    builder.paints("white paint #e7e2d8 0.5, steel #a9a9a6 0.3")
    builder.add("floorboards", rooms.level(_X, _Z, 0.0))
    builder.add("plaster", rooms.level(_X, _Z, -_HIGH).mirrored(1))
    builder.frame(0, (-_X, 0, -_Z)).add("sage plaster", rooms.wall(2 * _X, _HIGH))
    builder.frame(90, (-_X, 0, _Z)).add("plaster", rooms.wall(2 * _Z, _HIGH, [_WINDOW], 0.3))
    builder.frame(180, (_X, 0, _Z)).add("plaster", rooms.wall(2 * _X, _HIGH))
    builder.frame(-90, (_X, 0, -_Z)).add("plaster", rooms.wall(2 * _Z, _HIGH))
    cornice = points(
        "-.002,-.11 -.002,.002 .1,.002 .1,-.012 .082,-.02 .06,-.034 .042,-.054 .03,-.08 .012,-.095 .012,-.11"
    )
    builder.add("white paint", moulding(cornice, rectangle((-_X, -_Z), (_X, _Z))).moved(y=_HIGH))
    left, right = 2.35 - 0.53, 2.35 + 0.53  # the door's casing
    plan = [(right, _Z), (_X, _Z), (_X, -_Z), (-_X, -_Z), (-_X, _Z), (left, _Z)]
    builder.add("white paint", rooms.skirting(plan, 0.1))
    leaf, casing, handle = rooms.door(0.9, 2.1)
    at_door = builder.frame(180, (2.35, 0, _Z - 0.0155))
    at_door.add("white paint, white paint, steel", (leaf, casing.moved(z=-0.006), handle))


def _window(builder: Builder) -> None:
    builder.paints("window frame #e6e2d9 0.5")
    wall = builder.frame(90, (-_X, 0, _Z))
    wall.add("window frame", rooms.window_frame(_WINDOW, -0.22, 3, 0.06, 0.07))
    wall.add("window frame", rooms.sill(_WINDOW, 0.1, 0.14))
    _garden(wall)
    builder.textured("linen", partial(textures.fabric, 26, "#b9ae9c #d3c9b8 #e2dacb"), (0.2, 0.2), 1.0)
    for seed, middle in ((27, _WINDOW.left - 0.16), (28, _WINDOW.right + 0.16)):
        wall.add("linen", furnishings.curtain(0.72, 2.49, 7.5, 0.045, seed).moved(middle, 0, 0.17))
    wall.add("brass", furnishings.rod(_WINDOW.width + 1.3).moved(_WINDOW.left + _WINDOW.width / 2, 2.5, 0.17))


def _garden(wall: Builder) -> None:
    """What is seen through the window, as glowing bands: sky over far hills, a hedge and a lawn."""
    x = np.linspace(0.0, 1.0, 241)
    hills = 0.5 + 0.04 * np.sin(4.2 * x + 0.6) + 0.015 * np.sin(11.0 * x)
    lawn = 0.22 + 0.02 * np.sin(3.0 * x)
    hedge = 0.3 + 0.008 * np.sin(61.0 * x) + 0.006 * np.sin(97.0 * x + 2.0)
    crowns = points(".1,.3,.13 .2,.44,.11 .3,.36,.1 .62,.26,.1 .8,.34,.1 .88,.42,.09")
    for middle, height, radius in crowns:
        ragged = radius * (1.0 + 0.05 * np.sin(70.0 * x + 40.0 * middle))
        hedge = np.maximum(hedge, height + 1.4 * np.sqrt(np.maximum(ragged**2 - (x - middle) ** 2, 0.0)))
    hills = np.maximum(hills, hedge + 0.004)
    wall.light("lawn", (1.3, 1.8, 0.6))
    wall.light("hedge", (0.4, 0.7, 0.25))
    wall.light("hills", (2.4, 3.2, 3.4))
    wall.light("sky", (9.5, 10.8, 12.6))
    wall.add("lawn, hedge, hills, sky", rooms.bands(_WINDOW, 0.3, [lawn, hedge, hills]))


def _seats(builder: Builder) -> None:
    builder.textured("grey wool", partial(textures.fabric, 29, "#76736e #a19d96 #bdb9b0"), (0.14, 0.14), 1.0)
    builder.textured("mustard", partial(textures.fabric, 30, "#97702c #c3953f #d6ac5c"), (0.12, 0.12), 1.0)
    builder.textured("rust", partial(textures.fabric, 31, "#7c402b #a95b3f #c0765a"), (0.12, 0.12), 1.0)
    builder.textured("teal wool", partial(textures.fabric, 32, "#31524f #4a7470 #658f8a"), (0.14, 0.14), 1.0)
    builder.textured("knit", partial(textures.fabric, 33, "#a3937c #c6b79f #d9ccb6"), (0.25, 0.25), 1.0)
    builder.add("grey wool, walnut", [part.moved(-0.35, 0, -2.74) for part in seating.sofa(2.35, 3)])
    builder.add("mustard", seating.scatter((-1.12, 0.72, -2.61), 8.0))
    builder.add("mustard", seating.scatter((0.44, 0.7, -2.6), -14.0, 0.4))
    builder.add("rust", seating.scatter((-0.78, 0.69, -2.53), -10.0, 0.38))
    chair = builder.frame(104.0, (-2.3, 0, -1.0))
    chair.add("teal wool, walnut", seating.sofa(0.98, 1, 0.86))
    chair.add("rust", seating.scatter((0.0, 0.68, -0.16), 6.0, 0.4))
    builder.add("knit", seating.pouf(0.29, 0.38).moved(1.25, 0.013, -1.0))


def _coffee_table(builder: Builder) -> None:
    pattern = partial(textures.kilim, 34, "#c9b795 #8f4a37 #d9cdb4 #3f5a66 #b5784a")
    builder.textured("rug", pattern, (3.0, 2.1), 1.0)
    builder.add("rug", box((3.0, 0.012, 2.1), 0.004).mapped_uv(1.5, 1.05).moved(-0.35, 0.0065, -1.3))
    x, z, top = -0.45, -1.4, 0.4
    plate, legs = seating.stool_table(0.48, top - 0.013, 0.034)
    builder.add("walnut", [plate.moved(x, 0.013, z), legs.moved(x, 0.009, z)])
    top += 0.0005
    books = (("#3d5a73", 0.3, 12.0), ("#b0603f", 0.27, 20.0), ("#d8c9a8", 0.22, -8.0))
    pages = []
    for number, (colour, size, angle) in enumerate(books):
        left, right, near = -size / 2, size / 2, size * 0.36
        cover = [block((left, low, -near), (right, low + 0.003, near)) for low in (0.0, 0.024)]
        spine = block((left, 0.0035, -near), (left + 0.003, 0.0235, near))
        sheets = block((left + 0.004, 0.0035, -size * 0.35), (right - 0.002, 0.0235, size * 0.35))
        place = (x - 0.17, top + 0.0275 * number, z + 0.12)
        builder.paints(f"book cloth {colour} 0.8")
        builder.add("book cloth", [*cover, spine], place, angle)
        pages.append(sheets.at(place, angle))
    builder.paints("book pages #e6dfcd 0.9")
    builder.add("book pages", pages)
    builder.paints("orange #d68a35 0.6, apple #9db04a 0.4")
    builder.add("china, orange, apple", furnishings.bowl_of_fruit(35), (x + 0.17, top, z - 0.1))
    builder.add("china", mug(0.04, 0.095), (x + 0.12, top, z + 0.25), 40.0)


def _lamps(builder: Builder) -> None:
    builder.light("lamp shade", (3.8, 2.6, 1.4))
    builder.light("shade lining", (12.0, 8.0, 4.2))
    builder.add("brass", cylinder(0.15, 0.018, 48, 0.006).moved(1.22, 0.0005, -2.78))
    builder.add("brass", cylinder(0.011, 1.49, 20).moved(1.22, 0.01, -2.78))
    builder.add("lamp shade, shade lining", furnishings.drum_shade(0.22, 0.3), (1.22, 1.38, -2.78))
    builder.add("walnut", seating.stool_table(0.24, 0.5, 0.026), (-1.9, 0, -2.85))
    for x, y, z in ((-1.9, 0.5, -2.85), (3.02, 0.7605, 0.55)):
        builder.add("china", vase(0.085, 0.26).moved(x, y + 0.0005, z))
        builder.add("brass", cylinder(0.008, 0.16, 16).moved(x, y + 0.22, z))
        builder.add("lamp shade, shade lining", furnishings.drum_shade(0.17, 0.2, 0.8), (x, y + 0.33, z))
    builder.paints("lamp enamel #3f5a55 0.35, lamp inside #ece8de 0.8")
    builder.light("bulb", (45.0, 30.0, 16.0))
    builder.add("lamp enamel, lamp inside", furnishings.pendant(1.15), (-0.9, _HIGH, 1.95))
    builder.add("bulb", sphere(0.06, 24).moved(-0.9, _HIGH - 1.08, 1.95))


def _bookcase(builder: Builder) -> None:
    cloths = "#7b3b2e #2f4a5a #4d5a3c #a5803f #5c3a4a #c9b791 #3c4644 #8e5a3a"
    builder.textured("book spines", partial(textures.book_spines, 36, cloths), (1.0, 1.0), 0.8)
    builder.paints("pages #ddd5c2 0.9, blue glaze #56788c 0.3")
    half, tall, deep, board = 0.7, 2.16, 0.3, 0.025
    case = builder.frame(0, (2.35, 0.0005, -_Z + 0.0165))
    case.add("walnut", block((-half, 0, 0), (-half + board, tall, deep)).mapped_uv(swap=True))
    case.add("walnut", block((half - board, 0, 0), (half, tall, deep)).mapped_uv(swap=True))
    case.add("walnut", block((-half + board, 0.06, 0.0005), (half - board, tall - 0.0005, 0.012)))
    levels = [0.06, 0.43, 0.79, 1.13, 1.47, 1.81, tall - board - 0.0005]
    inner = half - board - 0.0005
    case.add("walnut", [block((-inner, y, 0.0125), (inner, y + board, deep - 0.004)) for y in levels])
    # Rows of books: their shelf, number on it, where they begin and how long they are.
    rows = ((0, 0, -0.66, 1.3), (1, 0, -0.66, 0.55), (1, 1, 0.16, 0.5), (2, 0, -0.64, 1.0), (3, 0, -0.3, 0.96))
    on = [level + board + 0.0005 for level in levels]
    for shelf, number, start, length in (*rows, (4, 0, -0.66, 0.72), (5, 0, -0.66, 0.4), (5, 1, 0.2, 0.45)):
        gap = levels[shelf + 1] - levels[shelf] - board
        row = furnishings.books(40 + 7 * shelf + number, length, gap * 0.86)
        case.add("book spines, pages", row, (start, on[shelf], deep - 0.035))
    case.add("blue glaze", vase(0.075, 0.24).moved(0.0, on[1], 0.15))
    case.add("blue glaze", sphere(0.07, 40).moved(0.3, on[4] + 0.07, 0.16))
    for shelf, x, radius, height in ((2, 0.5, 0.09, 0.2), (3, -0.5, 0.06, 0.26), (5, -0.03, 0.07, 0.19)):
        case.add("china", vase(radius, height).moved(x, on[shelf], 0.16))


def _dining(builder: Builder) -> None:
    x, z, high = -0.9, 1.95, 0.74
    builder.add("oak", slab(superellipse(0.88, 0.46, 5.0, 128), 0.034, 0.011, 3).moved(x, high - 0.034, z))
    corners = [(u, v) for u in (-1, 1) for v in (-1, 1)]
    for u, v in corners:
        leg = tube([(u * 0.76, 0.003, v * 0.34), (u * 0.68, high - 0.03, v * 0.28)], [0.019, 0.032], 20)
        builder.add("oak", leg.moved(x, 0, z))
    builder.add("oak", [box((1.3, 0.07, 0.022), 0.003).moved(x, high - 0.0695, z + side * 0.275) for side in (-1, 1)])
    builder.paints("black chair #46464a 0.5")
    builder.textured("seat pad", partial(textures.fabric, 50, "#9a8a70 #bfae92 #d3c5ac"), (0.12, 0.12), 1.0)
    places = [(x - 0.38, 0, z - 0.58), (x + 0.4, 0, z - 0.66), (x - 0.4, 0, z + 0.6), (x + 0.36, 0, z + 0.58)]
    builder.add("black chair, seat pad", seating.wooden_chair(), places, [4.0, -12.0, 177.0, 184.0])

    top = high + 0.0005
    plates = np.array([(x + u * 0.4, top, z + v * 0.27) for v in (-1, 1) for u in (-1, 1)])
    builder.add("china", saucer(0.13), plates)
    builder.add("china", saucer(0.09), plates + np.array([0, 0.0095, 0]))
    builder.paints("green glaze #5f7a5a 0.3, twigs #6f5b45 0.9")
    builder.textured("twig leaves", partial(textures.leaves, 52, "#56683f #82955c #aebb86"), (1.0, 1.0), 0.6)
    builder.add("green glaze, twigs, twig leaves", (vase(0.09, 0.24), *tree(51, 0.48, 26, 0.2)), (x, top, z))
    builder.add("china", mug(0.036, 0.08), [(x - 0.16, top, z - 0.22), (x + 0.62, top, z - 0.12)], [70.0, 200.0])


def _sideboard(builder: Builder) -> None:
    board = builder.frame(-90, (_X - 0.235, 0, 0.1))
    board.add("walnut", box((1.7, 0.5, 0.42), 0.006, 2).moved(0, 0.51, 0))
    for number in range(3):
        x = (number - 1) * 0.555
        door = box((0.548, 0.462, 0.016), 0.003).mapped_uv(0.37 * number, 0.11 * number, swap=True)
        board.add("walnut, brass", (door.moved(x, 0.51, 0.2105), sphere(0.012, 20).moved(x + 0.22, 0.6, 0.226)))
    leg = seating.tapered_leg(0.27, 0.02, 0.012)
    board.add("walnut", [leg.moved(x * 0.72, 0, z * 0.14) for x in (-1, 1) for z in (-1, 1)])
    board.add("china", vase(0.1, 0.34).moved(-0.6, 0.7605, 0.0))
    dish = lathe(points("0,.003 .1,0 .17,.035 .166,.037 .1,.006 0,.008"), 48)
    board.add("brass", dish.moved(-0.05, 0.7605, 0.03))


def _pictures(builder: Builder) -> None:
    builder.paints("picture frame #4a453f 0.5")
    hills = partial(paintings.landscape, 53, "#7fa3b5 #c9d3c4 #efd9ae", "#a9b3a6 #7f957f #58755f #3f5848")
    fields = partial(paintings.blocks, 54, "#e5d9c2 #c98a4b #7c3f34 #2f4858")
    bands = partial(paintings.strata, 55, "#294c60 #7fa1a0 #eadfc8 #d9a566 #a5563c")
    dunes = partial(paintings.landscape, 56, "#d7a98c #ecd2b0 #f3e4c4", "#c9a58a #a97d64 #7d5a4d")
    rooms.hang(builder.frame(0, (-0.35, 1.68, -_Z)), "oak", hills, 1.5, 0.95)
    rooms.hang(builder.frame(180, (-0.9, 1.6, _Z)), "picture frame", bands, 1.3, 0.85)
    rooms.hang(builder.frame(-90, (_X, 1.72, 0.1)), "picture frame", fields, 0.8, 1.0)
    rooms.hang(builder.frame(180, (0.75, 1.6, _Z)), "oak", dunes, 0.6, 0.75)


def _plants(builder: Builder) -> None:
    builder.textured("fig leaves", partial(textures.leaves, 57, "#385830 #5d8243 #97ae6c"), (1.0, 1.0), 0.5)
    builder.paints("bark #7c6a52 0.9, soil #4d4136 1.0, terracotta #b5714f 0.9")
    for seed, x, z, tall in ((58, -2.82, -2.75, 1.95), (59, -2.85, 2.8, 1.6)):
        fig = (*pot(0.21, 0.4), *tree(seed, tall, 220, 0.38))
        builder.add("terracotta, soil, bark, fig leaves", fig, (x, 0.0005, z))
