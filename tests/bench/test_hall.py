import numpy as np
import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.geometry.normals import area_vectors
from gpu.settings import Component, RenderSettings
from tests.bench.hall import make_hall


@pytest.mark.parametrize("wanted", [1_000, 30_000, 300_000])
def test_the_hall_has_as_many_triangles_as_wanted_and_keeps_its_shape(wanted: int) -> None:
    scene = make_hall(wanted)
    assert len(scene.triangles) == pytest.approx(wanted, rel=0.15)
    assert scene.report.dropped_triangles == 0
    area = np.linalg.norm(area_vectors(scene.vertices.astype(np.float64), scene.triangles), axis=1).sum() / 2.0
    finest = make_hall(100_000)
    exact = np.linalg.norm(area_vectors(finest.vertices.astype(np.float64), finest.triangles), axis=1).sum() / 2.0
    assert area == pytest.approx(exact, rel=0.1)


def test_every_front_faces_its_normals() -> None:
    scene = make_hall(20_000)
    fronts = area_vectors(scene.vertices.astype(np.float64), scene.triangles)
    assert (np.einsum("tc,tc->t", fronts, scene.normals[scene.triangles].mean(axis=1)) > 0.0).mean() > 0.999


def test_the_hall_is_lit_and_closed(cpu: str) -> None:
    device_scene = DeviceScene(make_hall(5_000), cpu)
    settings = RenderSettings(component=Component.DIRECT, lambertian=True, samples=4)
    frame = Renderer(device_scene, (48, 32), settings).render(device_scene.scene.cameras[0])
    assert frame.radiance().mean() > 0.01
    up = look_at((0.0, 0.9, 0.0), (0.5, 0.0, 0.3))
    stats = Renderer(device_scene, (48, 32), settings.model_copy(update={"component": Component.FULL})).render(up).stats
    assert stats.counts["empty"] == 0
