"""Each switch of gpu.settings.Skips: what the picture is without it, and that the statistics count it."""

import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.camera import look_at
from gpu.frame import Frame
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.settings import EVERY_SKIP, RenderSettings, Skips

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
QUALITY = {"sp_clusters": 200, "vpls": 2000, "vpl_clusters": 200}


def without(*names: str) -> Skips:
    return Skips(**dict.fromkeys(names, False))


def frame(resident: ResidentScene, skip: Skips = EVERY_SKIP, **settings: object) -> Frame:
    return Renderer(resident, SIZE, RenderSettings(**{**QUALITY, "skip": skip, **settings})).render(CAMERA)


def relative_error(x: Frame, r: Frame) -> float:
    picture, reference = x.radiance(), r.radiance()
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2)))


@pytest.fixture(scope="module")
def room() -> ResidentScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])


@pytest.fixture(scope="module")
def usual(room: ResidentScene) -> Frame:
    return frame(room)


@pytest.mark.parametrize(("name", "bound"), [("facing_away", 1e-3), ("weak_pairs", 1e-3)])
def test_rays_for_more_pairs_change_little(room: ResidentScene, usual: Frame, name: str, bound: float) -> None:
    other = frame(room, without(name))
    assert usual.stats.skips[name] > 0
    assert other.stats.skips[name] == 0
    assert other.stats.counts["rays"] == usual.stats.counts["rays"] + usual.stats.skips[name]
    print(name, relative_error(usual, other))
    assert relative_error(usual, other) < bound
