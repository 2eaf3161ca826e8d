import pytest
from pictures import lamp_room, picture, relative_error

from gpu.device_scene.upload import DeviceScene
from gpu.settings import Component, Method


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_exact_vpl_agrees_with_path_tracing(room: DeviceScene) -> None:
    settings = {"component": Component.INDIRECT, "lambertian": True}
    exact = picture(room, method=Method.EXACT_VPL, **settings, vpls=8000, vpl_clusters=400)
    paths = picture(room, method=Method.PATH, samples=256, **settings)
    assert exact.mean() == pytest.approx(paths.mean(), rel=0.04)
    assert relative_error(exact, paths) < 0.02
