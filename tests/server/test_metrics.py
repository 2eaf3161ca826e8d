import pytest

from server.metrics import Metrics
from server.wire.frame_header import Phase


def value(metrics: Metrics, name: str, **labels: str) -> float | None:
    return metrics.registry.get_sample_value(f"lumenwalk_{name}", labels)


def test_a_frame_is_counted_and_timed() -> None:
    metrics = Metrics()
    metrics.frame(4.0, 40.0, 3.0, 1000, Phase.STILL, {"shade": 12.0}, {"specular": 2})
    metrics.frame(4.0, 40.0, 3.0, 500, Phase.MOVING, {"shade": 14.0}, {"specular": 1})
    assert value(metrics, "frames_total", phase="still") == 1
    assert value(metrics, "frames_total", phase="final") == 0
    assert value(metrics, "frame_bytes_total") == 1500
    assert value(metrics, "latency_seconds_sum", part="queue") == 0.008
    assert value(metrics, "latency_seconds_sum", part="encode") == 0.006
    assert value(metrics, "latency_seconds_bucket", part="render", le="0.05") == 2
    assert value(metrics, "latency_seconds_bucket", part="render", le="0.03") == 0
    assert value(metrics, "stage_seconds_sum", stage="shade") == pytest.approx(0.026)
    assert value(metrics, "skips_total", what="specular") == 3


def test_what_a_viewer_does_not_say_is_not_counted() -> None:
    metrics = Metrics()
    metrics.acknowledged(None, 20.0, None)
    metrics.acknowledged(80.0, None, 5.0)
    assert value(metrics, "frame_age_seconds_count") == 1
    assert value(metrics, "frame_age_seconds_sum") == 0.08
    assert value(metrics, "latency_seconds_count", part="network") == 1
    assert value(metrics, "latency_seconds_sum", part="decode") == 0.005


def test_refused_and_dropped_by_reason() -> None:
    metrics = Metrics()
    metrics.refused("full")
    metrics.refused("full")
    metrics.dropped("stalled")
    assert value(metrics, "refused_total", reason="full") == 2
    assert value(metrics, "dropped_total", reason="stalled") == 1
