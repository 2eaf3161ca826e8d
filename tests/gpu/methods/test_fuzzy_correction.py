import numpy as np
import pytest
from scenes import box, grey, quad, resident_of, slats

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


def test_refinement_mends_what_clusters_get_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    device_scene, camera, size = slats()
    errors = []
    for seed in range(4):
        settings = RenderSettings(component=Component.INDIRECT, sp_clusters=80, vpls=4000, vpl_clusters=800, seed=seed,
                                  near_field=False)  # fmt: skip
        exact = Renderer(device_scene, size, settings.model_copy(update={"method": Method.EXACT_VPL}))
        reference = exact.render(camera).radiance()
        refined = Renderer(device_scene, size, settings).render(camera)
        with monkeypatch.context() as patched:
            patched.setattr("gpu.methods.fuzzy_correction.LEAST_DISPUTE", 4000.0)
            plain = Renderer(device_scene, size, settings).render(camera)
        assert refined.stats.counts["refined"] > 20
        assert plain.stats.counts["refined"] < refined.stats.counts["refined"]
        changed = (refined.radiance() != plain.radiance()).any(axis=2)
        assert changed.any()
        # The mean of the whole picture is what dark means, so those that were refined are compared inside it.
        weights = 1.0 / (reference[changed] ** 2 + 0.01 * reference.mean() ** 2)
        errors.append([np.mean((frame.radiance()[changed] - reference[changed]) ** 2 * weights)
                       for frame in (plain, refined)])  # fmt: skip
    before, after = np.mean(errors, axis=0)
    assert after < 0.5 * before
