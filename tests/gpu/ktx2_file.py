"""KTX 2 files in code: UASTC blocks of one colour each."""

import struct

from gpu.scene.formats.ktx2 import IDENTIFIER

_SOLID = 23  # the code of UASTC's mode 8, whose blocks have one colour, in 5 bits


def uastc_block(red: int, green: int, blue: int, alpha: int = 255) -> bytes:
    """4×4 pixels of one colour (UASTC specification, mode 8)."""
    value, at = _SOLID, 5
    for level in (red, green, blue, alpha):
        value |= level << at
        at += 8
    return value.to_bytes(16, "little")


def ktx2(blocks: list[list[bytes]], width: int, height: int) -> bytes:
    """A file of one level, from rows of 4×4 blocks: section 3 of the KTX 2 specification."""
    data = b"".join(block for row in blocks for block in row)
    # A basic data format descriptor: colour model UASTC, BT.709 primaries, sRGB, 4×4 blocks of 16 bytes, RGBA.
    sample = struct.pack("<HBBIII", 0, 127, 3, 0, 0, 0xFFFFFFFF)
    block = struct.pack("<IHHBBBBBBBB8B", 0, 2, 24 + len(sample), 166, 1, 2, 0, 3, 3, 0, 0, 16, *[0] * 7) + sample
    descriptor = struct.pack("<I", 4 + len(block)) + block
    start = 12 + 9 * 4 + 4 * 4 + 2 * 8 + 24
    level = -(-(start + len(descriptor)) // 16) * 16
    head = struct.pack("<9I", 0, 1, width, height, 0, 0, 1, 1, 0)
    index = struct.pack("<4I2Q", start, len(descriptor), 0, 0, 0, 0)
    levels = struct.pack("<3Q", level, len(data), len(data))
    body = IDENTIFIER + head + index + levels + descriptor
    return body + b"\0" * (level - len(body)) + data
