import numpy as np
import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.settings import Component, RenderSettings
from tests.bench import walk_errors


def test_the_worst_pixels_do_not_count() -> None:
    reference = np.ones((20, 50, 3))
    render = np.full((20, 50, 3), 1.1, np.float32)
    render[0, :5] = 100.0
    assert walk_errors.trimmed(render, reference) == pytest.approx(0.995 * 0.01 / 1.01, rel=1e-4)


def test_a_walk_ends_at_the_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walk_errors, "FRAMES", 3)
    monkeypatch.setattr(walk_errors, "FIRST", 1)
    counts = {"vpls": 1024, "vpl_clusters": 64, "sp_clusters": 64}
    settings = RenderSettings(component=Component.INDIRECT, **counts)  # a lamp is few of so few pixels
    device_scene = DeviceScene(load_scene("cornell-box"), "cpu")
    renderer, camera = Renderer(device_scene, (24, 16), settings), device_scene.scene.cameras[0]
    still = renderer.render(camera).radiance()
    row = walk_errors.measure(renderer, camera, still.astype(np.float64))
    assert row["sum_ms"] > 0.0
    assert row["energy"] == pytest.approx(1.0, abs=0.1)
