from itertools import pairwise

import pytest

from server.walk.video_choice import (
    FIRST_FRAMES,
    GAIN_SECONDS,
    JUDGED_FRAMES,
    MOST_FRAMES,
    PASSED_FRAMES,
    SMALL_BYTES,
    STAYS_FRAMES,
    VideoChoice,
)

JPEG, VIDEO = 40_000, 4_000
TRIED = PASSED_FRAMES + JUDGED_FRAMES


class Line:
    """A viewer on a line: a round trip without bytes [s], and so many bytes a second."""

    def __init__(self, trip: float, rate: float, jpeg: int = JPEG) -> None:
        self.trip, self.rate, self.jpeg = trip, rate, jpeg
        self.now, self.frame = 0.0, 0
        self.choice = VideoChoice(lambda: self.now)

    def send(self, extra: float = 0.0) -> bool:
        """One more frame, of the kind that was chosen, and its acknowledgement; whether it was video."""
        self.frame += 1
        is_video = self.choice.is_video
        size = VIDEO if is_video else self.jpeg
        self.choice.sent(self.frame, size, is_video=is_video)
        self.now += self.trip + extra + size / self.rate
        self.choice.acknowledged(self.frame)
        return is_video

    def walk(self, frames: int) -> list[bool]:
        return [self.send() for _ in range(frames)]


def rate(gain: float) -> float:
    """Bytes a second of a line on which video comes so much sooner than a JPEG [s]."""
    return (JPEG - VIDEO) / gain


def test_a_slow_line_has_video_soon() -> None:
    kinds = Line(0.06, 5e6 / 8).walk(FIRST_FRAMES + STAYS_FRAMES)
    assert kinds == [False] * FIRST_FRAMES + [True] * STAYS_FRAMES


def test_jpegs_are_tried_again_ever_less_often() -> None:
    kinds = Line(0.06, 5e6 / 8).walk(20_000)[FIRST_FRAMES:]
    tries = [frame for frame, kind in enumerate(kinds[1:]) if kinds[frame] and not kind]
    gaps = [later - sooner - TRIED for sooner, later in pairwise(tries)]
    assert gaps[:3] == [2 * STAYS_FRAMES, 4 * STAYS_FRAMES, 8 * STAYS_FRAMES]
    assert max(gaps) == MOST_FRAMES
    assert sum(kinds) > 0.98 * len(kinds)


def test_a_long_fast_line_tries_video_for_a_moment_and_has_jpegs() -> None:
    kinds = Line(0.3, 12.5e6).walk(2000)
    assert kinds[FIRST_FRAMES : FIRST_FRAMES + TRIED] == [True] * TRIED
    assert not any(kinds[FIRST_FRAMES + TRIED : FIRST_FRAMES + TRIED + 2 * FIRST_FRAMES])
    assert sum(kinds) < 0.1 * len(kinds)


def test_a_short_line_tries_nothing() -> None:
    assert not any(Line(0.5 * GAIN_SECONDS, 1e9).walk(1000))


@pytest.mark.parametrize(("share", "is_video"), [(1.05, True), (0.95, False)])
def test_video_is_kept_where_it_comes_so_much_sooner(share: float, is_video: bool) -> None:
    kinds = Line(0.05, rate(share * GAIN_SECONDS)).walk(FIRST_FRAMES + TRIED + 1)
    assert kinds[-1] is is_video


def test_a_line_that_got_faster_has_jpegs_again() -> None:
    line = Line(0.06, 5e6 / 8)
    line.walk(FIRST_FRAMES + TRIED)
    line.rate = rate(0.1 * GAIN_SECONDS)
    kinds = line.walk(STAYS_FRAMES + TRIED + STAYS_FRAMES)
    assert kinds[:STAYS_FRAMES] == [True] * STAYS_FRAMES
    assert not any(kinds[STAYS_FRAMES:])


def test_small_pictures_are_not_what_makes_a_line_slow() -> None:
    for size, is_video in ((SMALL_BYTES, False), (SMALL_BYTES + 1, True)):
        kinds = Line(0.05, size / 0.1, jpeg=size).walk(FIRST_FRAMES + 1)
        assert kinds[-1] is is_video


def test_the_first_frames_of_a_kind_are_not_judged() -> None:
    line = Line(0.06, rate(2.0 * GAIN_SECONDS))
    line.walk(FIRST_FRAMES)
    for _ in range(PASSED_FRAMES):
        line.send(extra=1.0)
    line.walk(JUDGED_FRAMES)
    assert line.choice.is_video


def test_frames_of_the_other_kind_and_those_passed_over_tell_nothing() -> None:
    choice = VideoChoice(lambda: 0.0)
    for frame in range(1, 100):
        choice.sent(frame, JPEG, is_video=True)
        choice.acknowledged(frame)
    choice.sent(100, JPEG, is_video=False)
    choice.sent(101, JPEG, is_video=False)
    choice.acknowledged(101)
    choice.acknowledged(100)
    assert not choice.is_video
    assert choice._frames == 1
