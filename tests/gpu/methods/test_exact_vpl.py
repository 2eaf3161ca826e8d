import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
QUALITY = {"sp_clusters": 200, "vpls": 2000, "vpl_clusters": 100}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])


def picture(device_scene: DeviceScene, **settings: object) -> Floats:
    """Linear radiance of a frame."""
    return Renderer(device_scene, SIZE, RenderSettings(**{**QUALITY, **settings})).render(CAMERA).radiance()


def relative_error(x: Floats, r: Floats) -> float:
    return float(np.mean((x - r) ** 2 / (r**2 + 0.01 * r.mean() ** 2)))


def test_exact_vpl_agrees_with_path_tracing(room: DeviceScene) -> None:
    settings = {"component": Component.INDIRECT, "lambertian": True}
    exact = picture(room, method=Method.EXACT_VPL, **settings, vpls=8000, vpl_clusters=400)
    paths = picture(room, method=Method.PATH, samples=256, **settings)
    assert exact.mean() == pytest.approx(paths.mean(), rel=0.04)
    assert relative_error(exact, paths) < 0.02
