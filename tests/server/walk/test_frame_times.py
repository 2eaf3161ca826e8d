import logging

import pytest

from server.metrics import Metrics
from server.walk.frame_times import SLOW_MS, FrameTimes
from server.wire.browser import Ack
from server.wire.frame_header import FrameHeader
from server.wire.worker import Done

DONE = Done(1, (64, 36), 12.0, 3.0, 1, 1, {"trace": 11.0}, {}, {"specular": 2})


def header(frame: int, render_ms: float = 12.0) -> FrameHeader:
    return FrameHeader(64, 36, 1, frame, 0, 5.0, render_ms, 3.0, {"trace": 11.0})


def seconds(metrics: Metrics, part: str) -> float | None:
    return metrics.registry.get_sample_value("lumenwalk_latency_seconds_sum", {"part": part})


def test_the_age_that_nobody_else_took_is_the_network_s() -> None:
    metrics = Metrics()
    times = FrameTimes(metrics)
    for frame in (1, 2):
        times.sending(header(frame))
        times.sent(header(frame), DONE, 1000)
    times.acknowledged(Ack(type="ack", frame=2, age_ms=32.0, decode_ms=4.0))
    assert seconds(metrics, "network") == pytest.approx(0.008)
    assert seconds(metrics, "decode") == pytest.approx(0.004)
    assert seconds(metrics, "queue") == pytest.approx(0.01)
    times.acknowledged(Ack(type="ack", frame=1, age_ms=32.0))  # covered by the one before
    assert seconds(metrics, "network") == pytest.approx(0.008)


def test_an_age_below_what_the_server_took_leaves_nothing_to_the_network() -> None:
    metrics = Metrics()
    times = FrameTimes(metrics)
    times.sending(header(1))
    times.acknowledged(Ack(type="ack", frame=1, age_ms=2.0))
    assert seconds(metrics, "network") == 0.0


def test_slow_frames_are_logged_now_and_then(caplog: pytest.LogCaptureFixture) -> None:
    times = FrameTimes(Metrics())
    with caplog.at_level(logging.WARNING, "lumenwalk.viewer"):
        times.sent(header(1, SLOW_MS - 9.0), DONE, 1000)
        assert caplog.records == []
        for frame in (2, 3):
            times.sent(header(frame, SLOW_MS), DONE, 1000)
    assert [record.message for record in caplog.records] == ["slow frame"]
