"""A frame's stages: run by name, timed, and on CUDA replayed as graphs."""

from collections.abc import Callable, Hashable
from itertools import count
from threading import Lock

import warp as wp

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING

# Held while a graph is captured, when nobody may use the device's default stream; threads that may do so hold it, too.
CAPTURING = Lock()
# Numbers for whatever owns arrays that captured graphs read; see `Stages.forget`.
new_number = count().__next__


class Stages:
    """Runs and times the named stages of one renderer's frames.

    On CUDA a stage is captured as a graph, so that its many small launches cost the host nothing: what it launches must
    be the same in every frame of one `graph_key`, and what differs must come through arrays. Times are of device events
    there, of the wall clock on the CPU. stepwise: frames are so long that others may have the device between the stages
    and within them: nothing is captured, nothing runs beside a stage, and times are of the wall clock, as always on a
    CPU. steady: whether the last frame's stages did nothing that only a first frame does; captured: whether the host
    captured any of them in that frame. lane: where they run, or None: on the device's current stream.
    """

    def __init__(self, device: wp.Device, lane: Lane | None = None) -> None:
        self._device = device
        self._events: dict[str, tuple[wp.Event, wp.Event]] = {}
        self._graphs: dict[tuple[str, Hashable, tuple[int, ...]], wp.Graph] = {}
        self._loaded: set[tuple[str, Hashable, bool]] = set()
        self._order: list[str] = []
        self._seconds: dict[str, float] = {}
        # What was forked runs on a stream of its own.
        self._lane = lane or Lane(device)
        self._forked: wp.Event | None = None
        self._joined: set[str] = set()
        self._forked_seconds: dict[str, float] = {}
        self.graph_key: tuple[int, ...] = ()
        self.stepwise = not device.is_cuda
        self.steady = self.captured = False

    def start_frame(self) -> None:
        """Forget the last frame's times."""
        self._order.clear()
        self._seconds.clear()
        self._joined.clear()
        self._forked_seconds.clear()
        self.steady, self.captured = True, False

    def forget(self, number: int) -> None:
        """Free the graphs whose key has this number, since arrays that they read are freed, too."""
        self._graphs = {key: graph for key, graph in self._graphs.items() if number not in key[2]}

    def run(self, name: str, work: Callable[[], None], *, repeats: bool = True, branch: Hashable = None,
            waits_for_fork: bool = False) -> None:  # fmt: skip
        """Run the stage `name`, once a frame. repeats: `work` launches the same every frame, so it may be captured.

        branch: which of several things the stage launches, where frames of one `graph_key` differ; waits_for_fork: it
        waits for what was forked, and that wait is part of its time.
        """
        self._order.append(name)
        if self.stepwise:
            self._seconds[name] = self._duration(work)
            if waits_for_fork:
                self._seconds[name] += self._forked_seconds.pop(name, 0.0)
            self._note((name, branch, repeats))
            return
        if name not in self._events:
            pair = wp.Event(self._device, enable_timing=True), wp.Event(self._device, enable_timing=True)
            self._events[name] = pair
        stream, (begin, end) = wp.get_stream(self._device), self._events[name]
        if waits_for_fork:
            stream.wait_event(self._forked)
            self._joined.add(name)

        def timed() -> None:
            # Events are part of the graph: what the host does for its first launch is no time of the device.
            stream.record_event(begin)
            work()
            stream.record_event(end)

        self._launch((name, branch, repeats), timed)

    def fork(self, name: str, part: str, work: Callable[[], None], *, repeats: bool = True,
             branch: Hashable = None) -> None:  # fmt: skip
        """Run `work`, a part of the stage `name`, beside the stages that follow, up to the first that waits for it.

        It comes after the stages before and what was forked before. It must write nothing that the stages beside it
        read, nor read what they write. On CUDA its time is what the stage `name` has to wait for it.
        """
        key = f"{name} {part}", branch, repeats
        if self.stepwise:
            self._forked_seconds[name] = self._forked_seconds.get(name, 0.0) + self._duration(work)
            self._note(key)
            return
        if self._forked is None:
            self._forked = wp.Event(self._device, enable_timing=True)
        with wp.ScopedStream(self._lane.side):
            self._launch(key, work)
            self._lane.side.record_event(self._forked)

    def run_untimed(self, work: Callable[[], None], *, branch: Hashable = None) -> None:
        """Run `work`, the same in every frame of one `graph_key`, in no stage's time.

        branch: which of several things that is.
        """
        if self.stepwise:
            work()
        else:
            self._launch(("", branch, True), work)

    def _duration(self, work: Callable[[], None]) -> float:
        """What `work` takes by the wall clock, but for turns of others [s]; then others may have one."""
        begun = DEVICE_SHARING.own_time()
        work()
        wp.synchronize_device(self._device)
        seconds = DEVICE_SHARING.own_time() - begun
        DEVICE_SHARING.pause()
        return seconds

    def _note(self, key: tuple[str, Hashable, bool]) -> bool:
        """Whether a stage has run before; its first run loads its kernels, whatever the `graph_key`."""
        loaded = key in self._loaded
        self._loaded.add(key)
        self.steady &= loaded
        return loaded

    def _launch(self, key: tuple[str, Hashable, bool], work: Callable[[], None]) -> None:
        """Launch on the current stream what `work` does, by a graph if it repeats and its kernels are loaded."""
        (name, branch, repeats), loaded = key, self._note(key)
        graph = self._graphs.get((name, branch, self.graph_key)) if repeats else None
        if repeats and loaded and graph is None:
            self.captured = True
            with CAPTURING, wp.ScopedCapture(self._device) as capture:
                work()
            graph = self._graphs[name, branch, self.graph_key] = capture.graph
        if graph is None:
            work()
        else:
            wp.capture_launch(graph)

    def milliseconds(self) -> dict[str, float]:
        """The stages' times [ms] in the order they ran, once the frame is ready."""
        if self.stepwise:
            return {name: 1e3 * self._seconds[name] for name in self._order}
        return {name: self._device_time(name) + self._waited(name) for name in self._order}

    def _device_time(self, name: str) -> float:
        return float(wp.get_event_elapsed_time(*self._events[name], synchronize=False))

    def _waited(self, name: str) -> float:
        """How long a stage had to wait for what was forked, once the stage before it was over [ms]."""
        place = self._order.index(name)
        if name not in self._joined or place == 0:
            return 0.0
        over = self._events[self._order[place - 1]][1]
        return max(float(wp.get_event_elapsed_time(over, self._forked, synchronize=False)), 0.0)
