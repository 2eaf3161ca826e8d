"""STEP files of boxes, written here: AP214 text (ISO 10303-21)."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

METRE = "SI_UNIT($,.METRE.)"
MILLIMETRE = "SI_UNIT(.MILLI.,.METRE.)"
# Corners are numbered 4x + 2y + z; each face counter-clockwise from outside, with its normal.
_FACES = {
    (0, 2, 6, 4): (0, 0, -1), (1, 5, 7, 3): (0, 0, 1), (0, 4, 5, 1): (0, -1, 0),
    (4, 6, 7, 5): (1, 0, 0), (6, 2, 3, 7): (0, 1, 0), (2, 0, 1, 3): (-1, 0, 0),
}  # fmt: skip
_HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
"""


@dataclass(frozen=True)
class Box:
    """A solid from `low` to `high` in the file's unit. color: encoded as on a display; transparency: 0 to 1."""

    low: tuple[float, float, float] = (0.0, 0.0, 0.0)
    high: tuple[float, float, float] = (1.0, 2.0, 3.0)
    color: tuple[float, float, float] | None = None
    transparency: float = 0.0


def step(*boxes: Box, unit: str = METRE, inch: bool = False) -> bytes:
    """A STEP file of `boxes`, whose unit of length is the SI `unit`, or an inch of them."""
    lines: list[str] = []

    def add(kind: str, *arguments: str) -> str:
        lines.append(f"{kind}({','.join(arguments)})" if kind else f"({''.join(arguments)})")
        return f"#{len(lines)}"

    def named(kind: str, *arguments: str) -> str:
        return add(kind, "''", *arguments)

    def numbers(kind: str, values: Sequence[float]) -> str:
        return named(kind, f"({','.join(repr(float(value)) for value in values)})")

    application = add("APPLICATION_CONTEXT", "''")
    contexts = named("PRODUCT_CONTEXT", application, "''"), named("PRODUCT_DEFINITION_CONTEXT", application, "'design'")
    length = add("", "LENGTH_UNIT()NAMED_UNIT(*)", unit)
    if inch:
        measure = add("LENGTH_MEASURE_WITH_UNIT", "LENGTH_MEASURE(25.4)", length)
        exponents = add("DIMENSIONAL_EXPONENTS", *"1000000")
        length = add("", f"CONVERSION_BASED_UNIT('INCH',{measure})LENGTH_UNIT()NAMED_UNIT({exponents})")
    angle = add("", "NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.)")
    units = f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({angle},{length}))"
    space = add("", "GEOMETRIC_REPRESENTATION_CONTEXT(3)", units, "REPRESENTATION_CONTEXT('','')")

    for box in boxes:
        corners = [
            [(box.low, box.high)[high][axis] for axis, high in enumerate(bits)] for bits in product((0, 1), repeat=3)
        ]
        points = [numbers("CARTESIAN_POINT", corner) for corner in corners]
        vertices = [named("VERTEX_POINT", point) for point in points]
        faces = []
        for corner_numbers, normal in _FACES.items():
            edges = []
            for a, b in zip(corner_numbers, (*corner_numbers[1:], corner_numbers[0]), strict=True):
                way = numbers("DIRECTION", [q - p for p, q in zip(corners[a], corners[b], strict=True)])
                line = named("LINE", points[a], named("VECTOR", way, "1."))
                edge = named("EDGE_CURVE", vertices[a], vertices[b], line, ".T.")
                edges.append(named("ORIENTED_EDGE", "*", "*", edge, ".T."))
            bound = named("FACE_OUTER_BOUND", named("EDGE_LOOP", f"({','.join(edges)})"), ".T.")
            across = numbers("DIRECTION", (0, 1, 0) if normal[0] else (1, 0, 0))
            place = named("AXIS2_PLACEMENT_3D", points[corner_numbers[0]], numbers("DIRECTION", normal), across)
            faces.append(named("ADVANCED_FACE", f"({bound})", named("PLANE", place), ".T."))
        solid = named("MANIFOLD_SOLID_BREP", named("CLOSED_SHELL", f"({','.join(faces)})"))
        shape = named("ADVANCED_BREP_SHAPE_REPRESENTATION", f"({solid})", space)
        part = named("PRODUCT", "''", "''", f"({contexts[0]})")
        part = named("PRODUCT_DEFINITION", "''", named("PRODUCT_DEFINITION_FORMATION", "''", part), contexts[1])
        add("SHAPE_DEFINITION_REPRESENTATION", named("PRODUCT_DEFINITION_SHAPE", "''", part), shape)
        if box.color:
            color = named("COLOUR_RGB", *map(repr, box.color))
            filled = named("FILL_AREA_STYLE", f"({named('FILL_AREA_STYLE_COLOUR', color)})")
            clear = add("SURFACE_STYLE_TRANSPARENT", repr(box.transparency))
            rendering = add("SURFACE_STYLE_RENDERING_WITH_PROPERTIES", ".NORMAL_SHADING.", color, f"({clear})")
            side = named("SURFACE_SIDE_STYLE", f"({add('SURFACE_STYLE_FILL_AREA', filled)},{rendering})")
            style = add("PRESENTATION_STYLE_ASSIGNMENT", f"({add('SURFACE_STYLE_USAGE', '.BOTH.', side)})")
            styled = named("STYLED_ITEM", f"({style})", solid)
            named("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION", f"({styled})", space)
    body = "\n".join(f"#{number}={line};" for number, line in enumerate(lines, 1))
    return f"{_HEAD}{body}\nENDSEC;\nEND-ISO-10303-21;\n".encode()
