"""What the service counts and times, for GET /metrics. Called from the event loop only; times come in milliseconds."""

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate

from prometheus_client import CollectorRegistry, Counter, ProcessCollector, disable_created_metrics
from prometheus_client.metrics_core import CounterMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.registry import Collector
from prometheus_client.utils import floatToGoString

from server.wire.frame_header import Phase

LATENCY_SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)
STAGE_SECONDS = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)
PARTS = ("queue", "render", "encode", "network", "decode")
PHASES = {phase: phase.name.lower() for phase in Phase}

disable_created_metrics()  # type: ignore[no-untyped-call]  # a second series for each counter, which says when it was made


# What every frame counts in, some thirty times: prometheus_client's own have a lock and take ten times as long.
class _Counts(Collector):
    """A counter for each value of a label."""

    def __init__(self, name: str, text: str, label: str, registry: CollectorRegistry) -> None:
        self._words, self._label = (name, text), label
        self._of: dict[str, int] = {}
        registry.register(self)

    def add(self, of: str, count: int) -> None:
        """So many more; it is told of, though it be 0."""
        self._of[of] = self._of.get(of, 0) + count

    def collect(self) -> Iterator[Metric]:
        """As of now."""
        family = CounterMetricFamily(*self._words, labels=[self._label])
        for of, count in self._of.items():
            family.add_metric([of], count)
        yield family


class _Times(Collector):
    """A histogram of seconds for each value of a label, or one; `bounds` are those of its buckets."""

    def __init__(
        self, name: str, text: str, label: str | None, bounds: Sequence[float], registry: CollectorRegistry
    ) -> None:
        self._words, self._labels, self._bounds = (name, text), [label] if label else None, bounds
        self._of: dict[str, list[float]] = {}  # how many in each bucket and above all, and the sum of all
        registry.register(self)

    def add(self, of: str, milliseconds: float | None) -> None:
        """One more; None: a value of the label that is to be told of."""
        found = self._of.get(of)
        if found is None:
            found = self._of[of] = [0.0] * (len(self._bounds) + 2)
        if milliseconds is not None:
            seconds = milliseconds / 1e3
            found[bisect_left(self._bounds, seconds)] += 1
            found[-1] += seconds

    def collect(self) -> Iterator[Metric]:
        """As of now."""
        family = HistogramMetricFamily(*self._words, labels=self._labels)
        names = [*map(floatToGoString, self._bounds), "+Inf"]
        for of, (*counts, total) in self._of.items():
            buckets = list(zip(names, accumulate(counts), strict=True))
            family.add_metric([of] if self._labels else [], buckets, total)
        yield family


class Metrics:
    """The counters and histograms of one service.

    `windows` holds the frames that each viewer, by number, may have unacknowledged.
    """

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.windows: dict[int, int] = {}
        ProcessCollector(registry=self.registry)
        of = self.registry
        self._frames = _Counts("lumenwalk_frames", "Frames sent.", "phase", of)
        self._bytes = Counter("lumenwalk_frame_bytes", "Bytes of frames sent, headers included.", registry=of)
        text = "Parts of a frame's way: waiting for its turn, rendering, encoding, both ways of the network, decoding."
        self._latency = _Times("lumenwalk_latency_seconds", text, "part", LATENCY_SECONDS, of)
        text = "From the sending of a pose until the viewer shows its first frame."
        self._age = _Times("lumenwalk_frame_age_seconds", text, None, LATENCY_SECONDS, of)
        self._stages = _Times("lumenwalk_stage_seconds", "Stages of a render.", "stage", STAGE_SECONDS, of)
        self._skips = _Counts("lumenwalk_skips", "Work that a scene or view did not need.", "what", of)
        self._refused = Counter("lumenwalk_refused", "Viewers and requests turned away.", ["reason"], registry=of)
        self._dropped = Counter("lumenwalk_dropped", "Viewers closed by the server.", ["reason"], registry=of)
        for name in PHASES.values():
            self._frames.add(name, 0)
        for part in PARTS:
            self._latency.add(part, None)
        self._age.add("", None)

    def frame(
        self,
        queue_ms: float,
        render_ms: float,
        encode_ms: float,
        size: int,
        phase: Phase,
        stages: Mapping[str, float],
        skips: Mapping[str, int],
    ) -> None:
        """A frame of `size` bytes was sent; `stages` [ms] and `skips` as of the renderer."""
        self._frames.add(PHASES[phase], 1)
        self._bytes.inc(size)
        for part, ms in (("queue", queue_ms), ("render", render_ms), ("encode", encode_ms)):
            self._latency.add(part, ms)
        for stage, ms in stages.items():
            self._stages.add(stage, ms)
        for what, count in skips.items():
            self._skips.add(what, count)

    def acknowledged(self, age_ms: float | None, network_ms: float | None, decode_ms: float | None) -> None:
        """A viewer has shown a frame; None is what it did not say."""
        self._age.add("", age_ms)
        self._latency.add("network", network_ms)
        self._latency.add("decode", decode_ms)

    def refused(self, reason: str) -> None:
        """A viewer or a request was turned away; `reason` is one of few words."""
        self._refused.labels(reason).inc()

    def dropped(self, reason: str) -> None:
        """The server has closed a viewer's connection; `reason` is one of few words."""
        self._dropped.labels(reason).inc()
