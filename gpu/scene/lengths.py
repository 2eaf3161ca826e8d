"""Lengths in words."""

_UNITS = {1000.0: "km", 1.0: "m", 0.01: "cm", 0.001: "mm"}


def length_text(metres: float) -> str:
    """A length above 0 with two digits or more, in the largest unit that it has one of: 460 km, 3.2 cm, 0.05 mm."""
    size, name = next(((size, name) for size, name in _UNITS.items() if metres >= size), (0.001, "mm"))
    value = metres / size
    return f"{value:,.0f} {name}" if 10.0 <= value < 1e6 else f"{value:.2g} {name}"
