"""A frame on its way to the browser: one binary message, little-endian, of a header and the image after it.

    offset  type      field
    0       u8        version of this layout: 3
    1       u8        codec: 1 = JPEG, 2 = PNG, 3 = H.264 (Annex B) that needs no earlier picture, 4 = H.264 that needs
                      that of the frame of codec 3 or 4 before it; an odd side is one pixel longer in its picture
    2       u16       header length in bytes, where the image starts
    4       u16       width [px]
    6       u16       height [px]
    8       u32       pose id
    12      u32       frame id
    16      u32       settings id, 0 before any settings message
    20      f32       queue [ms]: from the server's reading of the newer of pose and settings to the start of the render
    24      f32       render [ms]: wall time of all stages
    28      f32       encode [ms]
    32      u8        phase: 0 = moving, 1 = still, 2 = final: nothing follows before something changes
    33      u8        quality of the image, 1 to 100; 100 = lossless
    34      u16       frames averaged in the image
    36      u16       frames that the final image will average
    38                up to the image: UTF-8 JSON, an object of the stages' times [ms] by name, in the order they ran

Which stages there are is up to the method that rendered the frame.
"""

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

from gpu.errors import UserError

HEADER_VERSION = 3
LOSSLESS = 100
_fixed = struct.Struct("<BBHHHIIIfffBBHH")
FIXED_BYTES = _fixed.size
_quoted = lru_cache(1000)(json.dumps)  # names of stages: few, in every frame


class Codec(IntEnum):
    """How a frame's image is encoded."""

    JPEG = 1
    PNG = 2
    H264_KEY = 3
    H264 = 4


class Phase(IntEnum):
    """What a frame shows: a pose on the move, a still view that gets sharper, or one that is as sharp as it gets."""

    MOVING = 0
    STILL = 1
    FINAL = 2


@dataclass(frozen=True)
class FrameHeader:
    """What is said of a frame; times in milliseconds, `stage_ms` by the stages' names."""

    width: int
    height: int
    pose: int
    frame: int
    settings: int
    queue_ms: float
    render_ms: float
    encode_ms: float
    stage_ms: Mapping[str, float]
    codec: Codec = Codec.JPEG
    phase: Phase = Phase.MOVING
    quality: int = LOSSLESS
    samples: int = 1
    target_samples: int = 1

    def pack(self) -> bytes:
        """The bytes that go before the image."""
        stages = b"{%b}" % ",".join([f"{_quoted(name)}:{round(ms, 3)}" for name, ms in self.stage_ms.items()]).encode()
        fixed = _fixed.pack(
            *(HEADER_VERSION, self.codec, FIXED_BYTES + len(stages), self.width, self.height),
            *(self.pose, self.frame, self.settings),
            *(self.queue_ms, self.render_ms, self.encode_ms),
            *(self.phase, self.quality, self.samples, self.target_samples),
        )
        return fixed + stages


def unpack_frame(message: bytes) -> tuple[FrameHeader, bytes]:
    """Header and image of a binary message; UserError when it is not a frame of this version."""
    if len(message) < FIXED_BYTES or message[0] != HEADER_VERSION:
        raise UserError(
            f"not a frame of version {HEADER_VERSION}: {len(message)} bytes starting with {message[:4].hex()}"
        )
    _, codec, start, width, height, pose, frame, settings, queue, render, encode, *rest = _fixed.unpack_from(message)
    phase, quality, samples, target_samples = rest
    try:
        stages = json.loads(message[FIXED_BYTES:start])
        kinds = Codec(codec), Phase(phase)
    except (ValueError, RecursionError) as error:
        raise UserError(f"not a frame: its header is broken: {error}") from None
    header = FrameHeader(
        *(width, height, pose, frame, settings, queue, render, encode),
        *(stages, *kinds, quality, samples, target_samples),
    )
    return header, message[start:]
