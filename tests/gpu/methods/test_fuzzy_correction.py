from functools import partial

import numpy as np
import pytest
from pictures import lamp_room
from scenes import slats

from gpu.correction.outliers import OutlierParameters, OutlierPoints
from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.settings import Component, Method, RenderSettings


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_refinement_mends_what_clusters_get_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    device_scene, camera, size = slats()
    errors, nothing = [], OutlierParameters(least=4000.0)
    for seed in range(4):
        settings = RenderSettings(component=Component.INDIRECT, sp_clusters=80, vpls=4000, vpl_clusters=800, seed=seed,
                                  near_field=False)  # fmt: skip
        exact = Renderer(device_scene, size, settings.model_copy(update={"method": Method.EXACT_VPL}))
        reference = exact.render(camera).radiance()
        refined = Renderer(device_scene, size, settings).render(camera)
        with monkeypatch.context() as patched:
            patched.setattr("gpu.methods.fuzzy_correction.OutlierPoints", partial(OutlierPoints, quality=nothing))
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
