import numpy as np
import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.film.metrics import nonfinite_count
from gpu.renderer import Renderer
from gpu.settings import Method, RenderSettings
from tests.bench.unseen import ROOMS


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_is_sound_and_its_cameras_stand_in_it(name: str) -> None:
    scene = ROOMS[name]()
    assert scene.name == name
    assert not scene.report.notes
    assert len({camera.name for camera in scene.cameras}) == len(scene.cameras) >= 1
    for camera in scene.cameras:
        low, high = scene.bounds
        assert (camera.to_world[:3, 3] > low).all()
        assert (camera.to_world[:3, 3] < high).all()


def test_light_comes_through_the_door_that_is_ajar() -> None:
    scene = ROOMS["ajar"]()
    settings = RenderSettings(method=Method.PATH, samples=64)
    picture = Renderer(DeviceScene(scene, "cpu"), (24, 16), settings).render(scene.cameras[0]).radiance()
    assert nonfinite_count(picture) == 0
    door, wall = picture[5:10, 6:8].mean(), picture[5:10, :5].mean()
    assert door > 3.0 * wall > 0.0
    assert np.count_nonzero(picture) > picture.size // 2
