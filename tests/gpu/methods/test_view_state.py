import numpy as np
import pytest
from frame_view import FrameView
from scenes import box, grey, resident_of

from gpu.gbuffer.camera_rays import CameraData
from gpu.scene.camera import look_at

SIZE = (12, 8)


def test_the_camera_looks_with_the_aspect_of_the_image() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    view.set_camera(look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0), yfov_degrees=90.0, aspect=5.0))
    data = dict(zip(CameraData.vars, view.camera.numpy()[0], strict=True))
    assert np.isclose(data["half_height"], 1.0)
    assert np.isclose(data["half_width"], 1.5)


@pytest.mark.parametrize(("moved", "reuses"), [(0.4, True), (0.45, False)])
def test_a_frame_builds_on_one_that_saw_half_of_what_is_about_there(moved: float, reuses: bool) -> None:
    """Moved by a share of how wide the view is in the middle of a room; another side of things is new."""
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    x = moved * 2.0 * 1.5 * 0.3 / view._placement.scale
    for place in (0.0, x):
        camera = look_at((place, 0.0, 0.4), (place, 0.0, 0.0), yfov_degrees=90.0)
        view.set_camera(camera, walks=True)
    assert view.reuses_history == reuses


def test_light_ended_where_a_frame_of_the_walk_or_of_the_still_view_saw_it_end() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    one, other = (look_at((0.0, 0.0, 0.4), (x, 0.0, 0.0)) for x in (0.0, 0.01))

    def follows(*args: object, **options: bool) -> bool:
        before = view.camera.numpy().tobytes()
        view.set_camera(*args, **options)
        assert view.shading_points.before.camera.numpy().tobytes() == before
        return bool(view.shading_points.before.follows.numpy()[0])

    assert not follows(one)
    assert not follows(one)  # again from nothing
    assert follows(one, 1)
    assert not follows(other, 1)
    view.wrote_history = True
    assert not follows(one)
    view.wrote_history = True
    assert follows(other, walks=True)
    assert not follows(one, walks=True)  # nothing was kept
