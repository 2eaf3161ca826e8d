import numpy as np
import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at, rotated
from gpu.scene.load import load_scene
from gpu.settings import Component, RenderSettings
from tests.bench.timing import light_times, measure_frames

SETTINGS = RenderSettings(component=Component.INDIRECT, sp_clusters=16, vpl_clusters=8, vpls=64)


@pytest.fixture(scope="module")
def device_scene(cpu: str) -> DeviceScene:
    return DeviceScene(load_scene("cornell-box"), cpu)


def test_turning_by_nothing_is_the_camera_and_by_all_around_again() -> None:
    camera = look_at((1.0, 2.0, 3.0), (0.0, 1.0, 0.0))
    assert np.allclose(rotated(camera, 0.0).to_world, camera.to_world)
    assert np.allclose(rotated(camera, 360.0).to_world, camera.to_world)
    assert np.allclose(rotated(camera, 180.0).to_world[:3, 2], -camera.to_world[:3, 2])


def test_the_measured_frame_is_the_cameras_own(device_scene: DeviceScene) -> None:
    camera = device_scene.scene.cameras[0]
    measured = measure_frames(Renderer(device_scene, (16, 12), SETTINGS), camera, frames=4, warm_up=2)
    alone = Renderer(device_scene, (16, 12), SETTINGS).render(camera)
    assert measured.frames == 4
    assert measured.radiance.tobytes() == alone.radiance().tobytes()
    assert set(measured.stages) == set(alone.stats.stage_ms)


def test_frames_of_one_view_keep_its_picture(device_scene: DeviceScene) -> None:
    camera = device_scene.scene.cameras[0]
    measured = measure_frames(Renderer(device_scene, (16, 12), SETTINGS), camera, frames=4, warm_up=2, step=0.0)
    assert measured.stats.skips["unchanged_camera"] == 16 * 12
    assert set(measured.stages) == {"display"}


def test_light_is_made_anew_each_time(device_scene: DeviceScene) -> None:
    times = light_times(device_scene, SETTINGS, 2)
    assert len(times) == 2
    assert all(time["median"] > 0.0 for time in times.values())
