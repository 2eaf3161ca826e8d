"""A film in an MP4 file, which is there under its name once it is whole."""

import os
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from server.video.film_settings import FilmCodec, FilmSettings
from server.video.pictures import VideoError, av_library, check_size, say_colours, video_frame

SECONDS_A_KEY_FRAME = 2  # to which a player can jump


@dataclass(frozen=True)
class _Encoder:
    """One of libavcodec's encoders, its options, of a quality at which the eye sees no loss, and the sides it takes."""

    name: str
    options: dict[str, str]
    sides: range


_ENCODERS = {
    FilmCodec.H264: _Encoder("libx264", {"crf": "18", "preset": "medium"}, range(2, 16_385)),
    # With smaller sides it may wait for ever (SVT-AV1 4.1).
    FilmCodec.AV1: _Encoder("libsvtav1", {"crf": "24", "preset": "8"}, range(64, 8193)),
}


def check_film(size: tuple[int, int], codec: FilmCodec) -> None:
    """VideoError where films of this size (width, height) or codec cannot be made here."""
    av, encoder = av_library(), _ENCODERS[codec]
    try:
        av.codec.Codec(encoder.name, "w")
    except av.codec.codec.UnknownCodecError:
        raise VideoError(f"codec: this PyAV has no encoder {encoder.name} for {codec}; use h264") from None
    check_size(size)
    if not all(side in encoder.sides for side in size):
        least, most = encoder.sides[0], encoder.sides[-1]
        raise VideoError(f"size: {codec} needs sides of {least} to {most} pixels, not {size[0]}x{size[1]}")


class FilmFile:
    """A film that pictures are added to, a context: `path` has the film once it ends, and nothing of it if that fails.

    size: width and height [px]. Raises VideoError where it cannot be made or written.
    """

    def __init__(self, path: Path, size: tuple[int, int], settings: FilmSettings) -> None:
        check_film(size, settings.codec)
        self._path, self._partial = path, path.with_name(f".{path.name}.{os.getpid()}.part")
        self._pictures, self._ended = 0, False
        self.encoded_bytes = 0  # so far; the encoder keeps pictures for a while
        os.environ.setdefault("SVT_LOG", "1")  # libsvtav1 prints what it does unless told to say errors only
        av, encoder = av_library(), _ENCODERS[settings.codec]
        self._errors = (OSError, av.error.FFmpegError)
        try:
            self._partial.touch()
            # What a player must know first comes first in the file.
            self._container = av.open(str(self._partial), "w", format="mp4", options={"movflags": "+faststart"})
            self._stream = self._container.add_stream(encoder.name, rate=settings.fps, options=encoder.options)
        except self._errors as error:
            self._partial.unlink(missing_ok=True)
            raise self._refusal(error) from None
        context: Any = self._stream.codec_context
        context.width, context.height = size
        context.time_base = Fraction(1, settings.fps)
        context.gop_size = SECONDS_A_KEY_FRAME * settings.fps
        say_colours(context)

    def add(self, pixels: NDArray[np.uint8]) -> None:
        """One more picture (height, width, 3) in sRGB."""
        frame = video_frame(pixels)
        frame.pts, frame.time_base = self._pictures, self._stream.codec_context.time_base
        self._pictures += 1
        self._encode(frame)

    def finish(self) -> None:
        """Write what the encoder has left, and give the file its name; nothing where that was done."""
        if self._ended:
            return
        try:
            self._encode(None)
            self._container.close()
            self._partial.replace(self._path)
        except self._errors as error:
            raise self._refusal(error) from None
        finally:
            self.abandon()

    def abandon(self) -> None:
        """End it as it is, with nothing of it left; nothing happens where it was finished."""
        self._ended = True
        with suppress(*self._errors):
            self._container.close()
        self._partial.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()
        else:
            self.abandon()

    def _encode(self, frame: Any) -> None:
        try:
            for packet in self._stream.encode(frame):
                self.encoded_bytes += packet.size
                self._container.mux(packet)
        except self._errors as error:
            raise self._refusal(error) from None

    def _refusal(self, error: Exception) -> VideoError:
        return VideoError(f"{self._path.name}: cannot be written: {getattr(error, 'strerror', None) or error}")
