"""The window against simulated ways to a viewer: how many frames a second arrive, and how old they are."""

from collections import deque

import pytest

from server.walk.ack_window import LEAST, MOST, AckWindow
from server.wire.browser import WINDOW

RENDER = 1 / 60
FRAME_BYTES = 60_000


def walk(delay: float, bytes_a_second: float, seconds: float = 20.0) -> tuple[float, float]:
    """Frames a second, and mean age [s], in the second half of a walk over a way of this length and breadth."""
    now, frame, ready, wire_free = 0.0, 0, 0.0, 0.0
    window = AckWindow(lambda: now)
    arrivals: deque[tuple[float, int]] = deque()
    ages = []
    while now < seconds:
        events = [t for t in (ready if window.room else None, arrivals[0][0] if arrivals else None) if t is not None]
        now = max(now, min(events))
        if arrivals and arrivals[0][0] <= now:
            window.acknowledge(arrivals.popleft()[1])
        elif window.room and ready <= now:
            frame += 1
            window.add(frame)
            window.sent(frame)
            ready = now + RENDER
            wire_free = max(wire_free, now) + FRAME_BYTES / bytes_a_second
            arrivals.append((wire_free + delay, frame))  # out and back again
            if now > seconds / 2:
                ages.append(wire_free + delay / 2 - now)
    return len(ages) / (seconds / 2), sum(ages) / len(ages)


def test_a_long_broad_way_is_filled() -> None:
    rate, age = walk(delay=0.1, bytes_a_second=1e9)
    assert rate > 0.9 / RENDER
    assert age < 0.06


def test_a_narrow_way_has_no_queue() -> None:
    rate, age = walk(delay=0.002, bytes_a_second=1.3e6)
    assert rate > 0.9 * 1.3e6 / FRAME_BYTES
    assert age < 0.11


def test_a_near_viewer_gets_all_frames() -> None:
    rate, _ = walk(delay=0.001, bytes_a_second=1e8)
    assert rate > 0.95 / RENDER


def test_the_window_stays_within_its_bounds() -> None:
    now = 0.0
    window = AckWindow(lambda: now)
    assert window.limit == WINDOW
    for frame in range(1, 100):
        window.add(frame)
        window.sent(frame)
        assert window.room == (len(window) < window.limit)
        now += 0.01
        if not window.room:
            window.acknowledge(frame)
    assert window.limit == MOST
    for frame in range(100, 150):
        window.add(frame)
        window.sent(frame)
        now += 1.0
        window.acknowledge(frame)
    assert window.limit == LEAST


def test_an_acknowledgement_covers_older_frames() -> None:
    window = AckWindow(lambda: 0.0)
    for frame in (1, 2, 3):
        window.add(frame)
    window.acknowledge(2)
    assert len(window) == 1
    window.drop(3)
    assert len(window) == 0


def test_waiting_counts_from_the_sending_of_the_oldest_frame() -> None:
    now = 0.0
    window = AckWindow(lambda: now)
    assert window.waiting_seconds == 0.0
    window.add(1)
    now = 5.0
    assert window.waiting_seconds == 0.0  # rendered for long, which is not the viewer's fault
    window.sent(1)
    window.add(2)
    now = 7.0
    assert window.waiting_seconds == pytest.approx(2.0)
    window.sent(3)
    assert len(window) == 2
