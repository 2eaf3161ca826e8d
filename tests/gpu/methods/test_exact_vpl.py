import numpy as np
import pytest
from pictures import SIZE, lamp_room, mirror_room, picture, relative_error

from gpu.device_scene.upload import DeviceScene
from gpu.settings import Component, Method


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_exact_vpl_agrees_with_path_tracing(room: DeviceScene) -> None:
    settings = {"component": Component.INDIRECT, "lambertian": True}
    exact = picture(room, method=Method.EXACT_VPL, **settings, vpls=8000, vpl_clusters=400)
    paths = picture(room, method=Method.PATH, samples=128, **settings)
    assert exact.mean() == pytest.approx(paths.mean(), rel=0.04)
    assert relative_error(exact, paths) < 0.02


def test_mirrors_show_the_room_as_path_tracing_does() -> None:
    """Not as matt surfaces, which is what they are to `lambertian` views and to light between surfaces.

    Paths count a mirror as a bounce, chains do not.
    """
    room, settings = mirror_room(), {"bounces": 12, "samples": 16}
    exact = picture(room, method=Method.EXACT_VPL, **settings)
    paths = picture(room, method=Method.PATH, **{**settings, "samples": 128})
    shown = np.zeros(SIZE[::-1], bool)
    shown[11:22, 18:31] = True
    for part in (shown, ~shown):
        assert exact[part].mean() == pytest.approx(paths[part].mean(), rel=0.05)
        assert relative_error(exact[part], paths[part]) < 0.03
