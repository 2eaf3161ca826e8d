"""A frame's stages: run by name, timed, and on CUDA replayed as graphs."""

from collections.abc import Callable, Hashable
from time import perf_counter

import warp as wp


class Stages:
    """Runs and times the named stages of one renderer's frames.

    On CUDA a stage is captured as a graph, so that its many small launches cost the host nothing: what it launches must
    be the same every frame of one `variant`, and what differs must come through arrays. Times are device events there,
    wall clock on the CPU. steady: whether the last frame's stages did nothing that only a first frame does.
    """

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self._events: dict[str, tuple[wp.Event, wp.Event]] = {}
        self._graphs: dict[tuple[str, Hashable, Hashable], wp.Graph] = {}
        self._loaded: set[tuple[str, Hashable, bool]] = set()
        self._order: list[str] = []
        self._seconds: dict[str, float] = {}
        self.variant: Hashable = None
        self.steady = False

    def start_frame(self) -> None:
        """Forget the last frame's times."""
        self._order.clear()
        self._seconds.clear()
        self.steady = True

    def forget(self, variant: Hashable) -> None:
        """Free the graphs of a variant, whose arrays go too."""
        self._graphs = {key: graph for key, graph in self._graphs.items() if key[2] != variant}

    def run(self, name: str, work: Callable[[], None], *, repeats: bool = True, way: Hashable = None) -> None:
        """Run the stage `name`, once a frame. repeats: `work` launches the same every frame, so it may be captured.

        way: which of several things a stage launches, where it is not the same in every frame of a variant.
        """
        self._order.append(name)
        # A stage's first run loads its kernels, whatever the variant; later ones can be captured.
        loaded = (name, way, repeats) in self._loaded
        self._loaded.add((name, way, repeats))
        self.steady &= loaded
        if not self._device.is_cuda:
            begun = perf_counter()
            work()
            self._seconds[name] = perf_counter() - begun
            return
        if name not in self._events:
            pair = wp.Event(self._device, enable_timing=True), wp.Event(self._device, enable_timing=True)
            self._events[name] = pair
        stream, (begin, end) = wp.get_stream(self._device), self._events[name]

        def timed() -> None:
            stream.record_event(begin)
            work()
            stream.record_event(end)

        graph = self._graphs.get((name, way, self.variant)) if repeats else None
        if repeats and loaded and graph is None:
            # Its events are part of the graph: what the host does for its first launch is no time of the device.
            with wp.ScopedCapture(self._device) as capture:
                timed()
            graph = self._graphs[name, way, self.variant] = capture.graph
        if graph is None:
            timed()
        else:
            wp.capture_launch(graph)

    def milliseconds(self) -> dict[str, float]:
        """The stages' times [ms] in the order they ran; waits for the device."""
        if not self._device.is_cuda:
            return {name: 1e3 * self._seconds[name] for name in self._order}
        return {name: float(wp.get_event_elapsed_time(*self._events[name])) for name in self._order}
