from dataclasses import replace

import numpy as np
import pytest

from gpu.methods.view_overlap import VIEW_OVERLAP_PARAMETERS, is_seen_again, view_overlap
from gpu.scene.camera import look_at


@pytest.mark.parametrize("orthographic", [False, True])
def test_a_view_is_seen_again_as_far_as_the_last_one_saw_it(orthographic: bool) -> None:
    camera = replace(look_at((1, 2, 3), (1, 2, -7), yfov_degrees=60.0), orthographic=orthographic)

    def again(eye: tuple[float, float, float], target: tuple[float, float, float], zoom: float = 1.0) -> float:
        view = look_at(eye, target, yfov_degrees=60.0)
        view = replace(view, half_height=camera.half_height * zoom, orthographic=orthographic)
        return view_overlap(view, camera, 1.5, 2.0)

    assert again((1, 2, 3), (1, 2, -7)) == 1.0
    assert again((1, 2, 3), (1, 2, -7), zoom=0.5) == 1.0
    assert again((1, 2, 3), (1, 2, -7), zoom=2.0) == pytest.approx(0.25, abs=0.05)
    width = 2.0 * 1.5 * camera.half_height * (1.0 if orthographic else 2.0)
    assert again((1 + width / 2, 2, 3), (1 + width / 2, 2, -7)) == pytest.approx(0.5, abs=0.06)
    assert again((1 + 2 * width, 2, 3), (1 + 2 * width, 2, -7)) == 0.0
    assert again((1, 2, 3), (1, 2, 10)) == 0.0
    assert again((1, 2, -1), (1, 2, 3)) == 0.0  # the other side of what is there


@pytest.mark.parametrize(("degrees", "seen"), [(55.0, 1.0), (65.0, 0.0)])
def test_what_both_see_is_seen_from_a_like_side(degrees: float, seen: float) -> None:
    angle = np.radians(degrees)
    camera = look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), yfov_degrees=2.0)
    other = look_at((2.0 * np.sin(angle), 0.0, 2.0 * np.cos(angle)), (0.0, 0.0, 0.0), yfov_degrees=6.0)
    assert view_overlap(camera, other, 1.0, 2.0) == seen


def test_views_of_both_kinds_compare() -> None:
    camera = look_at((0, 0, 0), (0, 0, -1), yfov_degrees=90.0)
    plan = replace(camera, half_height=2.0, orthographic=True)
    assert view_overlap(camera, plan, 1.0, 2.0) == view_overlap(plan, camera, 1.0, 2.0) == 1.0
    assert view_overlap(plan, camera, 1.0, 1.0) == pytest.approx(0.25, abs=0.05)


@pytest.mark.parametrize("orthographic", [False, True])
def test_whether_enough_is_seen_again_is_what_the_share_says(
    orthographic: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cameras that are near each other, as those of a walk are, need no share for that."""
    counted, compared, same = list[float](), 0, 0

    def share(*args: object) -> float:
        counted.append(overlap)
        return overlap

    draw = np.random.default_rng(1)
    for _ in range(300):
        eye, target = draw.normal(size=3), draw.normal(size=3) * 4.0
        way = 10.0 ** draw.uniform(-3.0, 0.3)
        moved = eye + way * draw.normal(size=3), target + way * draw.normal(size=3)
        pair = [look_at(*map(tuple, one), yfov_degrees=draw.uniform(30.0, 90.0)) for one in ((eye, target), moved)]
        camera, last = (replace(one, orthographic=orthographic) for one in pair)
        overlap = view_overlap(camera, last, 1.5, 2.0)
        with monkeypatch.context() as patched:
            patched.setattr("gpu.methods.view_overlap.view_overlap", share)
            again = is_seen_again(camera, last, 1.5, 2.0)
        assert again == (overlap >= VIEW_OVERLAP_PARAMETERS.min_overlap)
        same, compared = same + again, compared + 1
    assert 50 < same < compared - 50
    assert (len(counted) == compared) if orthographic else (len(counted) <= compared - 0.5 * same)
