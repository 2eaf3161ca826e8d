"""Frames that are tried again, since they are seen to have a larger error than is wanted."""

from typing import Any

import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.adaptive.error_model import Estimate
from gpu.adaptive.error_probes import Probes
from gpu.adaptive.probe_gather import ProbeLight
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.frame import FrameStats
from gpu.methods.targeted_vpl import TargetedViewState, TargetedVpl
from gpu.renderer import Renderer
from gpu.scene.camera import look_at, rotated
from gpu.settings import Component, RenderSettings

SIZE = (32, 24)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
INDIRECT = {"component": Component.INDIRECT, "vpls": 1000, "skip": {"unchanged_camera": False}}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a lamp below its ceiling."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


def telling(monkeypatch: pytest.MonkeyPatch, error: float) -> list[float]:
    """What probes will tell of frames, in turn; the last of it stays."""
    told = [error]
    monkeypatch.setattr(Probes, "estimate", lambda _: Estimate(told.pop(0) if len(told) > 1 else told[0], 1e-6))
    return told


def gathering(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is gathered at probes from now on."""
    gathered, gather = [], ProbeLight.gather

    def counted(light: ProbeLight, *args: Any) -> None:
        gathered.append(args)
        gather(light, *args)

    monkeypatch.setattr(ProbeLight, "gather", counted)
    return gathered


def test_another_try_knows_what_probes_of_the_one_before_did(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    gathered = gathering(monkeypatch)
    told = telling(monkeypatch, 1.03e-3)
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=1e-3))
    before = renderer.render(CAMERA).stats.counts["vpl_clusters"]
    gathered.clear()
    told[:] = [1.2e-3, 1.03e-3]
    stats = renderer.render(rotated(CAMERA, 1.0)).stats
    assert (stats.estimates["tries"], stats.counts["vpl_clusters"]) == (2, before)
    assert len(gathered) == 1
    renderer.render(rotated(CAMERA, 2.0))
    assert len(gathered) == 2


def test_probes_know_nothing_of_a_try_that_failed(room: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("no memory")

    told = telling(monkeypatch, 1.03e-3)
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=1e-3))
    renderer.render(CAMERA)
    told[:] = [1.2e-3]
    with monkeypatch.context() as patched:
        tries_again = TargetedVpl._tries_again

        def then_fails(method: TargetedVpl, view: TargetedViewState) -> bool:
            patched.setattr("gpu.indirect.visibility.Visibility.trace", fail)
            return tries_again(method, view)

        patched.setattr(TargetedVpl, "_tries_again", then_fails)
        with pytest.raises(RuntimeError, match="no memory"):
            renderer.render(rotated(CAMERA, 1.0))
    gathered = gathering(monkeypatch)
    told[:] = [1.03e-3]
    renderer.render(rotated(CAMERA, 2.0))
    assert len(gathered) == 1


def test_a_frame_with_too_large_an_error_is_tried_up_to_seven_times_more(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = telling(monkeypatch, 1.03e-3)
    tried, add_times = [], FrameStats.after

    def after(better: FrameStats, before: FrameStats) -> FrameStats:
        tried.append([(stats.counts["vpl_clusters"], stats.counts["sp_clusters"]) for stats in (before, better)])
        return add_times(better, before)

    monkeypatch.setattr(FrameStats, "after", after)
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=1e-3))
    accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
    usual = renderer.render(CAMERA, accumulation)
    assert usual.stats.estimates["tries"] == 1
    cases = [([1.05e-3], 1), ([1.5e-3, 1.05e-3], 2), ([0.6e-3], 1), ([0.7e-3], 1), ([1.15e-3], 8)]
    for errors, tries in cases:
        told[:] = errors
        accumulation.restart()
        frame = renderer.render(CAMERA, accumulation)
        assert frame.stats.estimates["tries"] == tries
        assert (accumulation.samples, frame.stats.counts["frames"]) == (1, 1)
    assert all(better > before for before, better in tried)
    assert len(tried) == 8
    assert list(frame.stats.stage_ms) == list(usual.stats.stage_ms)
    same = RenderSettings(**INDIRECT, **{name: frame.stats.counts[name] for name in ("sp_clusters", "vpl_clusters")})
    assert np.allclose(frame.radiance(), Renderer(room, SIZE, same).render(CAMERA).radiance(), atol=1e-6)
    # Another frame of the still view is no new try, nor is one at the most counts.
    assert renderer.render(CAMERA, accumulation).stats.counts["frames"] == 2
    told[:] = [1.0]
    assert [renderer.render(CAMERA, walks=True).stats.estimates["tries"] for _ in range(12)][-1] == 1


def test_times_of_tries_are_added() -> None:
    first = FrameStats({"shade": 1.0, "near": 0.5}, {"vpls": 1}, {"far_field_sums": 1}, {"tries": 1.0})
    second = FrameStats({"shade": 2.0, "probe": 3.0}, {"vpls": 2}, {"far_field_sums": 2}, {"tries": 1.0})
    both = second.after(first)
    assert both == FrameStats(
        {"shade": 3.0, "near": 0.5, "probe": 3.0}, {"vpls": 2}, {"far_field_sums": 2}, {"tries": 2.0}
    )
    assert second.after(both).estimates == {"tries": 3.0}
