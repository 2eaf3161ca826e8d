"""A frame's stages: run by name, timed, and on CUDA replayed as graphs."""

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from threading import Lock

import warp as wp

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING

# Held while a graph is captured, when nobody may use the device's default stream; threads that may do so hold it, too.
CAPTURING = Lock()
# Numbers for whatever owns arrays that captured graphs read; see `Stages.forget`.
new_number = count().__next__


@dataclass(frozen=True)
class _Part:
    """What a stage launches, or a part of it: its name, which of several things, and whether that repeats, as key."""

    key: tuple[str, Hashable, bool]
    graph_key: tuple[int, ...]
    work: Callable[[], None]


class Stages:
    """Runs and times the named stages of one renderer's frames.

    On CUDA stages that follow one another are launched together, as one graph that was captured of them, so that their
    many small launches cost the host nothing: what they launch must be the same in every frame of one `graph_key`, and
    what differs must come through arrays. They are launched by `flush`, and before a stage that does not repeat: until
    then nothing may be launched that is to come after them. Times are of device events there, of the wall clock on the
    CPU. stepwise: frames are so long that others may have the device between the stages and within them: nothing is
    captured, nothing runs beside a stage, and times are of the wall clock, as always on a CPU. steady: whether the last
    frame's stages did nothing that only a first frame does; captured: whether the host captured any of them in that
    frame. lane: where they run, or None: on the device's current stream.
    """

    def __init__(self, device: wp.Device, lane: Lane | None = None) -> None:
        self._device = device
        self._events: dict[str, tuple[wp.Event, wp.Event]] = {}
        self._graphs: dict[tuple[tuple[str, Hashable, tuple[int, ...]], ...], wp.Graph] = {}
        self._parts: list[_Part] = []  # that are not launched yet
        self._loaded: set[tuple[str, Hashable, bool]] = set()
        self._order: list[str] = []
        self._seconds: dict[str, float] = {}
        # What was forked runs on a stream of its own. Of two events for each stage that say when it is over, one tells
        # the time, and the other what has to come after it: in a graph none does both.
        self._lane = lane or Lane(device)
        self._forked: dict[str, tuple[wp.Event, wp.Event]] = {}
        # Stages of which something was forked that nothing has waited for, in order, by what is forked apart, if it is.
        self._open: dict[str | None, list[str]] = {}
        self._joined: set[str] = set()
        self._forked_seconds: dict[str, float] = {}
        self._ahead: str | None = None  # the last of the stages that those of now run beside
        self._beside: dict[str, str] = {}  # the last of those that a stage ran beside, by its name
        self.graph_key: tuple[int, ...] = ()
        self.stepwise = not device.is_cuda
        self.steady = self.captured = False

    def start_frame(self) -> None:
        """Forget the last frame's times."""
        self._order.clear()
        self._seconds.clear()
        self._joined.clear()
        self._forked_seconds.clear()
        self._beside.clear()
        self._parts, self._open = [], {}  # of a frame that failed
        self.steady, self.captured = True, False

    def forget(self, number: int) -> None:
        """Free the graphs whose key has this number, since arrays that they read are freed, too."""
        self._graphs = {
            parts: graph for parts, graph in self._graphs.items() if all(number not in key for _, _, key in parts)
        }

    def run(self, name: str, work: Callable[[], None], *, repeats: bool = True, branch: Hashable = None,
            waits_for_fork: bool = False) -> None:  # fmt: skip
        """Run the stage `name`, once a frame. repeats: `work` launches the same every frame, so it may be captured.

        branch: which of several things the stage launches, where frames of one `graph_key` differ; waits_for_fork: it
        waits for what was forked as part of it, or before that, and that wait is part of its time.
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
        begin, end = self._events[name]
        if waits_for_fork:
            self._joined.add(name)
        if self._ahead is not None:
            self._beside[name] = self._ahead

        def timed() -> None:
            if waits_for_fork:
                self.join(name)
            # Events are part of the graph: what the host does for its first launch is no time of the device.
            stream = wp.get_stream(self._device)
            stream.record_event(begin)
            work()
            stream.record_event(end)

        self._add((name, branch, repeats), timed)

    def fork(self, name: str, part: str, work: Callable[[], None], *, repeats: bool = True,
             branch: Hashable = None, apart: bool = False) -> None:  # fmt: skip
        """Run `work`, a part of the stage `name`, beside the stages that follow, up to that one, which waits for it.

        It comes after the stages before and what was forked before. It must write nothing that the stages beside it
        read, nor read what they write. On CUDA its time is what the stage `name` has to wait for it. apart: whether all
        that is forked for that stage runs beside what is forked for others, too.
        """
        key = f"{name} {part}", branch, repeats
        if self.stepwise:
            self._forked_seconds[name] = self._forked_seconds.get(name, 0.0) + self._duration(work)
            self._note(key)
            return
        if name not in self._forked:
            self._forked[name] = wp.Event(self._device, enable_timing=True), wp.Event(self._device)

        def beside() -> None:
            stream = self._lane.apart(name) if apart else self._lane.side
            opened = self._open.setdefault(name if apart else None, [])
            with wp.ScopedStream(stream):
                work()
                for event in self._forked[name]:
                    stream.record_event(event)
            opened[:] = [*(other for other in opened if other != name), name]

        self._add(key, beside)

    @contextmanager
    def beside(self) -> Iterator[None]:
        """Run stages beside those so far, of which they must read nothing, nor write what these read.

        What follows comes after both. On CUDA the host may wait in here for what is launched in here, and the times of
        these stages are what they take once the others are over.
        """
        if self.stepwise:
            yield
            return
        stream, ahead = wp.get_stream(self._device), self._lane.ahead
        with wp.ScopedStream(ahead):
            self.flush()
        self._ahead = self._order[-1] if self._order else None
        try:
            yield
            self.flush()
        finally:
            self._ahead = None
            stream.wait_stream(ahead)

    def run_untimed(self, work: Callable[[], None], *, branch: Hashable = None) -> None:
        """Run `work`, the same in every frame of one `graph_key`, in no stage's time.

        branch: which of several things that is.
        """
        if self.stepwise:
            work()
        else:
            self._add(("", branch, True), work)

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

    def _add(self, key: tuple[str, Hashable, bool], work: Callable[[], None]) -> None:
        """Have `work` launched with the parts before it, or at once, after them, if it does not repeat."""
        if key[2]:
            self._parts.append(_Part(key, self.graph_key, work))
            return
        self.flush()
        self._note(key)
        work()

    def flush(self) -> None:
        """Launch the stages so far on the current stream: by a graph, if their kernels are loaded."""
        parts, self._parts = self._parts, []
        if not parts:
            return
        key = tuple((*part.key[:2], part.graph_key) for part in parts)
        first = {part.key for part in parts} - self._loaded
        for part in parts:
            self._note(part.key)
        if first:
            self._launch(parts)
            return
        graph = self._graphs.get(key)
        self.join()
        if graph is None:
            self.captured = True
            with CAPTURING, wp.ScopedCapture(self._device) as capture:
                self._launch(parts)
            graph = self._graphs[key] = capture.graph
        wp.capture_launch(graph)

    def _launch(self, parts: list[_Part]) -> None:
        for part in parts:
            part.work()
        self.join()

    def join(self, name: str | None = None) -> None:
        """Have what follows on the current stream come after what was forked: up to parts of the stage `name`, or all.
        In a graph, what is launched only if a condition holds must come after all: nothing else may be under way where
        its condition is.
        """
        for opened in self._open.values():
            last = name or (opened[-1] if opened else None)
            if last in opened:
                wp.get_stream(self._device).wait_event(self._forked[last][1])
                del opened[: opened.index(last) + 1]

    def milliseconds(self) -> dict[str, float]:
        """The stages' times [ms] in the order they ran, once the frame is ready."""
        if self.stepwise:
            return {name: 1e3 * self._seconds[name] for name in self._order}
        return {name: self._device_time(name) + self._waited(name) for name in self._order}

    def _device_time(self, name: str) -> float:
        begin, end = self._events[name]
        taken = float(wp.get_event_elapsed_time(begin, end, synchronize=False))
        if name not in self._beside:
            return taken
        over = self._events[self._beside[name]][1]
        return max(min(taken, float(wp.get_event_elapsed_time(over, end, synchronize=False))), 0.0)

    def _waited(self, name: str) -> float:
        """How long a stage had to wait for what was forked, once the stages before it were over [ms]."""
        place = self._order.index(name)
        if name not in self._joined or place == 0:
            return 0.0
        before, forked = self._order[place - 1], self._forked[name][0]
        overs = (self._events[one][1] for one in {before, self._beside.get(before, before)})
        return max(min(float(wp.get_event_elapsed_time(it, forked, synchronize=False)) for it in overs), 0.0)
