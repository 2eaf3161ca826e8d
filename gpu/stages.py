"""A frame's stages: run by name, timed, and on CUDA replayed as graphs."""

from collections.abc import Callable
from time import perf_counter

import warp as wp

# A stage's first run loads its kernels and its second is captured; from the third on the graph is replayed.
CAPTURED_RUN = 1


class Stages:
    """Runs and times the named stages of one renderer's frames.

    On CUDA a stage is captured as a graph, so that its many small launches cost the host nothing: what it launches must
    be the same every frame, and what differs must come through arrays. Times are device events there, wall clock on
    the CPU.
    """

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self._events: dict[str, tuple[wp.Event, wp.Event]] = {}
        self._graphs: dict[str, wp.Graph] = {}
        self._runs: dict[str, int] = {}
        self._order: list[str] = []
        self._seconds: dict[str, float] = {}

    def start_frame(self) -> None:
        """Forget the last frame's times."""
        self._order.clear()
        self._seconds.clear()

    def run(self, name: str, work: Callable[[], None], *, repeats: bool = True) -> None:
        """Run the stage `name`, once a frame. repeats: `work` launches the same every frame, so it may be captured."""
        self._order.append(name)
        if not self._device.is_cuda:
            begun = perf_counter()
            work()
            self._seconds[name] = perf_counter() - begun
            return
        if name not in self._events:
            pair = wp.Event(self._device, enable_timing=True), wp.Event(self._device, enable_timing=True)
            self._events[name] = pair
        if repeats:
            runs = self._runs.get(name, 0)
            self._runs[name] = runs + 1
            if runs == CAPTURED_RUN:
                with wp.ScopedCapture(self._device) as capture:
                    work()
                self._graphs[name] = capture.graph
        stream = wp.get_stream(self._device)
        stream.record_event(self._events[name][0])
        if repeats and name in self._graphs:
            wp.capture_launch(self._graphs[name])
        else:
            work()
        stream.record_event(self._events[name][1])

    def milliseconds(self) -> dict[str, float]:
        """The stages' times [ms] in the order they ran; waits for the device."""
        if not self._device.is_cuda:
            return {name: 1e3 * self._seconds[name] for name in self._order}
        return {name: float(wp.get_event_elapsed_time(*self._events[name])) for name in self._order}
