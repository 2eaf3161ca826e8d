"""What the service counts and times, for GET /metrics. Called from the event loop only; times come in milliseconds."""

from collections.abc import Mapping
from functools import cache

from prometheus_client import CollectorRegistry, Counter, Histogram, ProcessCollector, disable_created_metrics

from server.wire.frame_header import Phase

LATENCY_SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)
STAGE_SECONDS = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)
PARTS = ("queue", "render", "encode", "network", "decode")

disable_created_metrics()  # type: ignore[no-untyped-call]  # a second series for each counter, which says when it was made


class Metrics:
    """The counters and histograms of one service.

    `windows` holds the frames that each viewer, by number, may have unacknowledged.
    """

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.windows: dict[int, int] = {}
        ProcessCollector(registry=self.registry)
        of = self.registry
        self._frames = Counter("lumenwalk_frames", "Frames sent.", ["phase"], registry=of)
        self._bytes = Counter("lumenwalk_frame_bytes", "Bytes of frames sent, headers included.", registry=of)
        self._latency = Histogram(
            "lumenwalk_latency_seconds",
            "Parts of a frame's way: waiting for its turn, rendering, encoding, both ways of the network, decoding.",
            ["part"],
            buckets=LATENCY_SECONDS,
            registry=of,
        )
        self._age = Histogram(
            "lumenwalk_frame_age_seconds",
            "From the sending of a pose until the viewer shows its first frame.",
            buckets=LATENCY_SECONDS,
            registry=of,
        )
        self._stages = Histogram(
            "lumenwalk_stage_seconds", "Stages of a render.", ["stage"], buckets=STAGE_SECONDS, registry=of
        )
        self._skips = Counter("lumenwalk_skips", "Work that a scene or view did not need.", ["what"], registry=of)
        self._refused = Counter("lumenwalk_refused", "Viewers and requests turned away.", ["reason"], registry=of)
        self._dropped = Counter("lumenwalk_dropped", "Viewers closed by the server.", ["reason"], registry=of)
        for phase in Phase:
            self._frames.labels(phase.name.lower())
        # To look a series up by its labels takes longer than to count in it.
        self._parts = {part: self._latency.labels(part) for part in PARTS}
        self._stage, self._skip = cache(self._stages.labels), cache(self._skips.labels)

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
        self._frames.labels(phase.name.lower()).inc()
        self._bytes.inc(size)
        for part, ms in (("queue", queue_ms), ("render", render_ms), ("encode", encode_ms)):
            self._parts[part].observe(ms / 1e3)
        for name, ms in stages.items():
            self._stage(name).observe(ms / 1e3)
        for name, count in skips.items():
            skip = self._skip(name)  # which is told of, though it be 0
            if count:
                skip.inc(count)

    def acknowledged(self, age_ms: float | None, network_ms: float | None, decode_ms: float | None) -> None:
        """A viewer has shown a frame; None is what it did not say."""
        if age_ms is not None:
            self._age.observe(age_ms / 1e3)
        for part, ms in (("network", network_ms), ("decode", decode_ms)):
            if ms is not None:
                self._parts[part].observe(ms / 1e3)

    def refused(self, reason: str) -> None:
        """A viewer or a request was turned away; `reason` is one of few words."""
        self._refused.labels(reason).inc()

    def dropped(self, reason: str) -> None:
        """The server has closed a viewer's connection; `reason` is one of few words."""
        self._dropped.labels(reason).inc()
