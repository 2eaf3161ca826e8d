import pytest

from server.walk.frame_request import FrameRequest
from server.wire.frame_header import Codec, FrameHeader, Phase
from server.wire.worker import Done


def request(samples: int | None, frame: int | None = 9) -> FrameRequest:
    return FrameRequest(frame, 4, 2, 1.5, 3, samples, 85, Codec.PNG)


def done(samples: int, target: int = 8) -> Done:
    return Done(1, (64, 36), 12.0, 3.0, samples, target, {"trace": 11.0}, {}, {})


@pytest.mark.parametrize(("samples", "refines"), [(None, False), (1, False), (2, True)])
def test_only_later_frames_of_a_rest_refine(samples: int | None, refines: bool) -> None:
    assert request(samples).refines is refines


@pytest.mark.parametrize(
    ("samples", "have", "phase", "target"),
    [(None, 1, Phase.MOVING, 1), (4, 4, Phase.STILL, 8), (8, 8, Phase.FINAL, 8), (8, 1, Phase.STILL, 8)],
)
def test_a_frame_says_what_it_shows_and_what_it_took(samples: int | None, have: int, phase: Phase, target: int) -> None:
    assert request(samples).header(done(have)) == FrameHeader(
        64, 36, 4, 9, 2, 1.5, 12.0, 3.0, {"trace": 11.0}, Codec.PNG, phase, 85, have, target
    )


def test_a_frame_that_is_not_shown_has_no_header() -> None:
    with pytest.raises(AssertionError):
        request(4, frame=None).header(done(4))
