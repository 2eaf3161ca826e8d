import random

import pytest

from server.walk.video_choice import (
    EARLY_SECONDS,
    JUDGED_FRAMES,
    LATE_SECONDS,
    LEAST_SPREAD,
    REMEMBERED_FRAMES,
    SMALL_BYTES,
    STAYS_FRAMES,
    VideoChoice,
)

JPEG, VIDEO = 40_000, 4_000


class Line:
    """A viewer on a line: a round trip without bytes [s], and so many bytes a second; JPEGs vary by a share."""

    def __init__(self, trip: float, rate: float, jpeg: int = JPEG, varies: float = 0.2) -> None:
        self.trip, self.rate, self.jpeg, self.varies = trip, rate, jpeg, varies
        self.now, self.frame = 0.0, 0
        self.choice = VideoChoice(lambda: self.now)

    def send(self) -> bool:
        """One more frame, of the kind that was chosen, and its acknowledgement; whether it was video."""
        self.frame += 1
        is_video, side = self.choice.is_video, 1.0 if self.frame % 2 else -1.0
        size = round((VIDEO if is_video else self.jpeg) * (1.0 + side * self.varies))
        self.choice.sent(self.frame, size, is_moving_jpeg=not is_video)
        self.now += self.trip + size / self.rate
        self.choice.acknowledged(self.frame)
        return is_video

    def walk(self, frames: int) -> list[bool]:
        return [self.send() for _ in range(frames)]


def test_a_fast_line_has_jpegs_however_long_it_is() -> None:
    assert not any(Line(0.3, 12.5e6).walk(1000))


def test_a_slow_line_has_video_soon_and_keeps_it() -> None:
    kinds = Line(0.06, 5e6 / 8).walk(1000)
    assert kinds.index(True) == JUDGED_FRAMES
    assert all(kinds[kinds.index(True) :])


@pytest.mark.parametrize(("share", "is_video"), [(1.1, True), (0.9, False)])
def test_jpegs_are_late_when_they_take_so_long(share: float, is_video: bool) -> None:
    line = Line(0.02, JPEG / (share * LATE_SECONDS))
    line.walk(4 * JUDGED_FRAMES)
    assert line.choice.is_video is is_video


def test_small_pictures_are_not_what_makes_a_line_slow() -> None:
    for size, is_video in ((int(0.9 * SMALL_BYTES), False), (int(1.1 * SMALL_BYTES), True)):
        line = Line(0.02, size / (2.0 * LATE_SECONDS), jpeg=size)
        line.walk(4 * JUDGED_FRAMES)
        assert line.choice.is_video is is_video


@pytest.mark.parametrize(("share", "is_video"), [(1.3, True), (0.7, False)])
def test_a_line_that_got_faster_has_jpegs_again_after_a_while(share: float, is_video: bool) -> None:
    line = Line(0.02, 5e6 / 8)
    line.walk(2 * JUDGED_FRAMES)
    assert line.choice.is_video
    line.rate = JPEG / (share * EARLY_SECONDS)
    kinds = line.walk(STAYS_FRAMES + 2 * JUDGED_FRAMES)
    assert kinds[-1] is is_video
    assert all(kinds[: STAYS_FRAMES - 2 * JUDGED_FRAMES])


def test_a_viewer_who_is_slow_at_random_is_no_slow_line() -> None:
    random.seed(4)
    line = Line(0.02, 12.5e6)
    for _ in range(200):
        line.trip = random.uniform(0.02, 0.04)
        line.send()
    assert not line.choice.is_video


def test_what_was_long_ago_is_forgotten() -> None:
    line = Line(0.06, 12.5e6)
    line.walk(500)
    line.rate = 5e6 / 8
    assert line.walk(REMEMBERED_FRAMES)[-1]


@pytest.mark.parametrize(("varies", "is_video"), [(0.8 * LEAST_SPREAD, False), (1.2 * LEAST_SPREAD, True)])
def test_frames_of_one_size_tell_nothing(varies: float, is_video: bool) -> None:
    assert Line(0.06, 5e6 / 8, varies=varies).walk(100)[-1] is is_video


def test_frames_that_were_passed_over_tell_nothing() -> None:
    choice = VideoChoice(lambda: 0.0)
    for frame in (1, 2):
        choice.sent(frame, JPEG, is_moving_jpeg=True)
    choice.acknowledged(2)
    choice.acknowledged(1)
    assert not choice.is_video
