"""Lanes: places for frames that are on a device at the same time, each on a stream of its own."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from time import perf_counter

import warp as wp

# Frames that may be on a GPU at once, since each leaves most of it idle; and memory that it has for each, whose
# renderers have arrays of their own [bytes].
CUDA_FRAMES, FRAME_BYTES = 8, 5 << 30
# After this, a frame that is not over is waited for, which tells what the device failed by, if it did.
LATE_SECONDS = 0.25


def frames_at_once(device: wp.Device) -> int:
    """How many frames may be on a device at once. On a CPU one: each launch has all cores, and is over on return."""
    return min(max(device.total_memory // FRAME_BYTES, 1), CUDA_FRAMES) if device.is_cuda else 1


class Flight:
    """What a lane has been given to do up to now."""

    def __init__(self, device: wp.Device, stream: wp.Stream | None) -> None:
        """stream: None where all is done already."""
        self._late = perf_counter() + LATE_SECONDS
        self._end = None if stream is None else stream.record_event(wp.Event(device))

    def is_over(self) -> bool:
        """Whether `wait` would return, or raise, without much of a wait."""
        return self._end is None or self._end.is_complete or perf_counter() > self._late

    def wait(self) -> None:
        """Return when all is done. RuntimeError when the device failed."""
        if self._end is not None:
            wp.synchronize_event(self._end)


class Lane:
    """Streams of a CUDA device: one for a frame's stages, `side` for what runs beside them, `apart` for what runs
    beside both for one stage, and `ahead` for stages that others do not wait for.

    A frame that begins comes after all that the device's current stream has been given before. Whoever runs in a lane
    must not give the host away before it has left it: Warp's current stream is the same for all.
    """

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self._apart: dict[str, wp.Stream] = {}

    @cached_property
    def _stream(self) -> wp.Stream | None:
        return wp.Stream(self._device, priority=-1) if self._device.is_cuda else None

    @cached_property
    def side(self) -> wp.Stream:
        """Of usual priority: what is there runs on what the stages leave free."""
        return wp.Stream(self._device)

    def apart(self, name: str) -> wp.Stream:
        """As `side`, for the stage of that name alone."""
        if name not in self._apart:
            self._apart[name] = wp.Stream(self._device)
        return self._apart[name]

    @cached_property
    def ahead(self) -> wp.Stream:
        """Of usual priority: what runs beside it has the host wait for it."""
        return wp.Stream(self._device)

    @contextmanager
    def entered(self) -> Iterator[None]:
        """Launches go to this lane in here."""
        with wp.ScopedStream(self._stream):
            yield

    def flight(self) -> Flight:
        """All that has been launched in this lane."""
        return Flight(self._device, self._stream)
