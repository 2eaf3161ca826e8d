import pytest
from frame_view import FrameView
from scenes import box, grey, resident_of

from gpu.methods.frame_kind import frame_kind, frame_seed, light_samples
from gpu.settings import RenderSettings

SIZE = (12, 8)


@pytest.mark.parametrize(
    ("sample", "length", "smooth", "expected"),
    [
        (0, 0, True, {"index": 0, "refines": False, "denoise": True, "read_history": False, "write_history": True}),
        (0, 3, True, {"index": 3, "refines": False, "denoise": True, "read_history": True, "write_history": True}),
        (3, 0, True, {"index": 3, "refines": False, "denoise": True, "read_history": False, "write_history": False}),
        (4, 0, True, {"index": 4, "refines": True, "denoise": False, "read_history": False, "write_history": False}),
        (0, 0, False, {"index": 0, "refines": False, "denoise": False, "read_history": False, "write_history": False}),
        (63, 0, True, {"index": 63, "refines": True, "shades_all": False, "denoise": False}),
        (64, 0, True, {"index": 64, "refines": True, "shades_all": True, "denoise": False}),
    ],
)
def test_a_frames_number_tells_what_is_done_in_it(
    sample: int, length: int, smooth: bool, expected: dict[str, object]
) -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    view.history_length = length
    kind = frame_kind(RenderSettings(smooth=smooth, seed=7), view, sample)
    assert {name: getattr(kind, name) for name in expected} == expected
    assert kind.seed == frame_seed(7, kind.index)
    assert kind.captured == (sample == 0)


def test_later_frames_of_a_still_view_have_four_light_samples_or_more() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    first, later = (frame_kind(RenderSettings(), view, sample) for sample in (0, 4))
    assert [light_samples(usual, first) for usual in (1, 2, 16)] == [1, 2, 16]
    assert [light_samples(usual, later) for usual in (1, 2, 16)] == [4, 4, 16]


def test_frames_have_seeds_of_their_own_and_the_first_has_that_of_the_settings() -> None:
    assert frame_seed(5, 0) == 5
    assert len({frame_seed(5, number) for number in range(1000)}) == 1000
