import pytest

from server.rest.requests import RenderRequest


@pytest.mark.parametrize(
    ("settings", "frames", "samples"),
    [
        ({}, 1, None),
        ({"frames": 8}, 8, None),
        ({"samples": 36}, 1, 36),
        ({"samples": 37}, 2, 19),
        ({"samples": 4096}, 114, 36),
        ({"method": "path"}, 1, None),
        ({"method": "path", "samples": 4}, 1, 4),
        ({"method": "path", "samples": 5}, 2, 3),
        ({"method": "path", "samples": 1024}, 256, 4),
        ({"method": "path", "samples": 8, "frames": 3}, 6, 4),
    ],
)
def test_a_picture_is_the_mean_of_frames_that_take_a_turn(
    settings: dict[str, object], frames: int, samples: int | None
) -> None:
    count, each = RenderRequest.model_validate({"settings": settings}).frames()
    assert (count, each.samples, each.frames) == (frames, samples, None)


def test_a_large_picture_takes_a_sample_a_turn_and_a_small_one_many() -> None:
    large = RenderRequest.model_validate({"size": (7680, 4320), "settings": {"method": "path", "samples": 3}})
    assert large.frames()[0] == 3
    small = RenderRequest.model_validate({"size": (16, 8), "settings": {"method": "path", "samples": 65}})
    assert small.frames()[0] == 2
    assert (small.weight(), large.weight()) == (2, 1)
