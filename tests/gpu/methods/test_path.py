import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings

SIZE = (24, 18)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a lamp below its ceiling."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


def traced(room: DeviceScene, **choice: object) -> Floats:
    settings = RenderSettings.model_validate({"method": Method.PATH, "samples": 64, **choice})
    return Renderer(room, SIZE, settings).render(CAMERA).radiance()


def test_samples_of_several_launches_are_those_of_one(room: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = traced(room)
    monkeypatch.setattr("gpu.methods.path.PATHS_PER_CPU_LAUNCH", 5 * SIZE[0] * SIZE[1])
    assert np.allclose(traced(room), whole, rtol=1e-5, atol=1e-6)


def test_more_samples_have_less_noise(room: DeviceScene) -> None:
    truth = traced(room, samples=512, seed=9)
    few, many = (np.mean((traced(room, samples=samples) - truth) ** 2) for samples in (4, 64))
    assert many < 0.2 * few


def test_components_add_up(room: DeviceScene) -> None:
    full, direct, indirect = (traced(room, component=component, samples=256) for component in Component)
    assert (direct + indirect).mean() == pytest.approx(full.mean(), rel=0.02)


def test_progress_ends_with_the_last_sample(room: DeviceScene) -> None:
    told: list[float] = []
    settings = RenderSettings(method=Method.PATH, samples=8)
    Renderer(room, SIZE, settings, lambda _, fraction: told.append(fraction)).render(CAMERA)
    assert told[-1] == 1.0
