"""The sRGB colour space as an ICC profile of half a kilobyte, for files that can name their colours in no other way.

ICC.1:2010 (version 4.3): a display profile of a matrix and a parametric curve, with a profile connection space of XYZ.
"""

import struct
from collections.abc import Sequence

_D50 = (0.9642, 1.0, 0.8249)
# IEC 61966-2-1's primaries, adapted from D65 to D50 by the Bradford transform, and that transform.
_PRIMARIES = {
    b"rXYZ": (0.4360747, 0.2225045, 0.0139322),
    b"gXYZ": (0.3850649, 0.7168786, 0.0971045),
    b"bXYZ": (0.1430804, 0.0606169, 0.7141733),
}
_BRADFORD = (1.0478112, 0.0228866, -0.0501270, 0.0295424, 0.9904844, -0.0170491, -0.0092345, 0.0150436, 0.7521316)
# Y = (a X + b)^g from X = d on, Y = c X below: g, a, b, c, d.
_CURVE = (2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045)
_PARAMETRIC_TYPE = 3
_HEADER_BYTES = 128


def _fixed(values: Sequence[float]) -> bytes:
    """Numbers as s15Fixed16."""
    return struct.pack(f">{len(values)}i", *(round(value * 65536) for value in values))


def _xyz(values: Sequence[float]) -> bytes:
    return b"XYZ " + bytes(4) + _fixed(values)


def _text(words: str) -> bytes:
    """A multiLocalizedUnicodeType of one language."""
    data = words.encode("utf-16-be")
    return b"mluc" + struct.pack(">IIIHHII", 0, 1, 12, 0x656E, 0x5553, len(data), 28) + data


def _profile() -> bytes:
    curve = b"para" + struct.pack(">IHH", 0, _PARAMETRIC_TYPE, 0) + _fixed(_CURVE)
    tags = {
        b"desc": _text("sRGB"),
        b"cprt": _text("CC0"),
        b"wtpt": _xyz(_D50),
        b"chad": b"sf32" + bytes(4) + _fixed(_BRADFORD),
        **{name: _xyz(values) for name, values in _PRIMARIES.items()},
        **dict.fromkeys((b"rTRC", b"gTRC", b"bTRC"), curve),
    }
    table, data = struct.pack(">I", len(tags)), b""
    start = _HEADER_BYTES + len(table) + 12 * len(tags)
    places: dict[bytes, int] = {}
    for name, tag in tags.items():
        if tag not in places:  # the three curves are one
            places[tag] = start + len(data)
            data += tag + bytes(-len(tag) % 4)
        table += name + struct.pack(">II", places[tag], len(tag))
    header = struct.pack(
        ">I4xI4s4s4s6H4s24xI",
        *(start + len(data), 0x04300000, b"mntr", b"RGB ", b"XYZ ", *(2000, 1, 1, 0, 0, 0), b"acsp", 0),
    )
    return (header + _fixed(_D50)).ljust(_HEADER_BYTES, b"\0") + table + data


SRGB_PROFILE = _profile()
