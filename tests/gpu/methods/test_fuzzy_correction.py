from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from pictures import CAMERA, CURTAIN, QUALITY, SIZE, curtained_room, lamp_room, long_room, picture
from scenes import slats

from gpu.correction.outliers import OutlierParameters, OutlierPoints
from gpu.correction.visibility_correction import Correction, RayPasses
from gpu.correction.vpl_connections import connect
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_correction import FuzzyCorrection, FuzzyCorrectionParameters
from gpu.renderer import Renderer
from gpu.scene.types import Material
from gpu.settings import Component, Method, RenderSettings


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_refinement_mends_what_clusters_get_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    device_scene, camera, size = slats()
    errors, nothing = [], OutlierParameters(least=4000.0)
    for seed in range(2):
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
    assert after < min(0.7 * before, 0.013)


def test_so_many_points_a_cluster_have_more_rays(room: DeviceScene) -> None:
    frame = FrameArrays(room, SIZE, lambertian=False)
    correction = FuzzyCorrection(frame, 1, 200, 100)
    assert [points.capacity for points in (correction.suspected, correction.refined, correction.bright)] == [
        400,
        150,
        800,
    ]
    few = FuzzyCorrection(frame, 1, 200, 100, quality=FuzzyCorrectionParameters(suspected=1.0, refined=0.5, bright=2.0))
    assert [points.capacity for points in (few.suspected, few.refined, few.bright)] == [200, 100, 400]


@pytest.mark.parametrize("near_field", [True, False])
def test_later_frames_of_a_still_view_have_three_passes(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch, near_field: bool
) -> None:
    traced, connected, trace = [], [], Correction.trace

    def noted(self: Correction, *inputs: Any) -> None:
        passes: RayPasses = inputs[-1]
        if passes.numbers.start == 0:
            traced.append(len(passes.numbers))
        trace(self, *inputs)

    def connects(*inputs: Any) -> None:
        connected.append(inputs[-1].passes)
        connect(*inputs)

    monkeypatch.setattr(Correction, "trace", noted)
    monkeypatch.setattr("gpu.methods.fuzzy_correction.connect", connects)
    settings = RenderSettings(**QUALITY, near_field=near_field)
    renderer, mean = Renderer(room, SIZE, settings), Accumulation(SIZE[0] * SIZE[1], room.device)
    for _ in range(5):
        frame = renderer.render(CAMERA, mean)
    weights = [renderer._method.weight(number) for number in (0, 3, 4)]
    assert weights == ([3.0, 3.0, 1.0] if near_field else [1.0] * 3)
    # Light of VPLs alone is what is wanted where near-field light is not.
    assert (traced, connected) == (([1] * 4, [3]) if near_field else ([1] * 4 + [3], []))
    assert ("connect" in frame.stats.stage_ms) == ("paths" in frame.stats.stage_ms) == near_field
    assert frame.stats.counts["near"] == 0


def test_later_frames_have_light_of_walls_that_shine_as_path_tracing_has() -> None:
    """Not evenly, by which walls beside the lamp would be 4 % too bright, the far one 3 % too dark."""
    room, camera = long_room()
    settings = {**QUALITY, "component": Component.INDIRECT, "bounces": 1, "vpls": 4000}
    renderer, mean = Renderer(room, SIZE, RenderSettings(**settings)), Accumulation(SIZE[0] * SIZE[1], room.device)
    first, frames = np.zeros((*SIZE[::-1], 3)), 16
    for number in range(frames):
        shown = renderer.render(camera, mean).radiance().astype(np.float64)
        if number == 3:
            first = shown
    weight = 12 / (12 + frames - 4)
    later = (shown - first * weight) / (1.0 - weight)
    paths = picture(room, camera, **settings, method=Method.PATH, samples=1024)
    for part in (np.s_[:, :], np.s_[9:27, 16:32]):
        assert later[part].mean() == pytest.approx(paths[part].mean(), rel=0.018)


@pytest.mark.parametrize(
    "parting",
    [
        CURTAIN,
        replace(CURTAIN, sheen_color=(0.8, 0.8, 0.8), sheen_roughness=0.5),
        Material(transmission=0.5, roughness=0.0, double_sided=True),
    ],
)
def test_later_frames_show_both_sides_of_a_curtain_or_pane_as_path_tracing_does(parting: Material) -> None:
    room, frames = curtained_room(parting), 36
    renderers = (
        Renderer(room, SIZE, RenderSettings(**QUALITY)),
        Renderer(room, SIZE, RenderSettings(method=Method.PATH, samples=16)),
    )
    means = [Accumulation(SIZE[0] * SIZE[1], room.device) for _ in renderers]
    firsts = [np.zeros((*SIZE[::-1], 3)) for _ in renderers]
    for number in range(frames):
        for renderer, mean, first in zip(renderers, means, firsts, strict=True):
            shown = renderer.render(CAMERA, mean).radiance().astype(np.float64)
            if number == 3:
                first[:] = shown
    weights = 12 / (12 + frames - 4), 4 / frames
    fuzzy, paths = ((mean.mean.numpy().reshape(*SIZE[::-1], 3) - first * weight) / (1.0 - weight)
                    for mean, first, weight in zip(means, firsts, weights, strict=True))  # fmt: skip
    assert fuzzy.mean() == pytest.approx(paths.mean(), rel=0.01 if parting is CURTAIN else 0.02)
    middle = np.s_[9:27, 16:32]
    assert fuzzy[middle].mean(axis=(0, 1)) == pytest.approx(paths[middle].mean(axis=(0, 1)), rel=0.02)
