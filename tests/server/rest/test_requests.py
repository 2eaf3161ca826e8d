import pytest

from server.rest.requests import RenderRequest
from server.wire.worker import CameraMatrix


@pytest.mark.parametrize(
    ("settings", "frames", "samples"),
    [
        ({}, 1, None),
        ({"frames": 8}, 8, None),
        ({"samples": 128}, 1, 128),
        ({"method": "path"}, 1, None),
        ({"method": "path", "samples": 64}, 1, 64),
        ({"method": "path", "samples": 65}, 2, 33),
        ({"method": "path", "samples": 1024}, 16, 64),
        ({"method": "path", "samples": 100, "frames": 3}, 6, 50),
    ],
)
def test_a_picture_is_the_mean_of_frames_of_at_most_64_paths(
    settings: dict[str, object], frames: int, samples: int | None
) -> None:
    count, each = RenderRequest.model_validate({"settings": settings}).frames()
    assert (count, each.samples, each.frames) == (frames, samples, None)


def test_a_camera_of_ones_own_may_cut_away_what_is_near() -> None:
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    view = RenderRequest.model_validate({"camera": {"matrix": matrix, "yfov_degrees": 60, "near": 4.5}}).view()
    assert isinstance(view, CameraMatrix)
    assert view.near == 4.5
