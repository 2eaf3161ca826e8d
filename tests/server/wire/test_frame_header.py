import struct

import pytest

from gpu.errors import UserError
from server.wire.frame_header import FIXED_BYTES, Codec, FrameHeader, Phase, unpack_frame


def header(stages: dict[str, float]) -> FrameHeader:
    return FrameHeader(
        *(0x0102, 0x0304, 5, 2**32 - 1, 7, 0.5, 12.25, 1.5, stages),
        *(Codec.PNG, Phase.FINAL, 85, 3, 64),
    )


@pytest.mark.parametrize("stages", [{}, {"gbuffer": 0.5, "a stage of another method": 12.25}])
def test_a_header_survives_the_wire_with_whatever_stages_there_are(stages: dict[str, float]) -> None:
    sent = header(stages)
    received, image = unpack_frame(sent.pack() + b"image")
    assert (received, image) == (sent, b"image")
    assert list(received.stage_ms) == list(stages)


def test_the_header_has_the_documented_layout() -> None:
    packed = header({"trace": 2.0}).pack()
    start = FIXED_BYTES + len('{"trace":2.0}')
    assert packed[:20] == bytes([3, 2, start, 0, 2, 1, 4, 3, 5, 0, 0, 0, 255, 255, 255, 255, 7, 0, 0, 0])
    assert packed[20:38] == struct.pack("<fffBBHH", 0.5, 12.25, 1.5, 2, 85, 3, 64)
    assert packed[38:] == b'{"trace":2.0}'


@pytest.mark.parametrize("message", [b"", b"\x03" * 37, b"\x02" + bytes(96)])
def test_what_is_not_a_frame_is_refused(message: bytes) -> None:
    with pytest.raises(UserError, match="not a frame"):
        unpack_frame(message)
