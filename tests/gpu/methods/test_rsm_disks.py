"""Pictures of `rsm-disks` beside path tracing of one bounce, and what a walk keeps."""

import pytest
import warp as wp
from pictures import QUALITY, SIZE, lamp_room, picture, relative_error
from walking import pose

from gpu.device_scene.upload import DeviceScene
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.rsm_disks import RsmDisks
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings

ONE_BOUNCE = {"component": Component.INDIRECT, "bounces": 1}
RSM = {**QUALITY, **ONE_BOUNCE, "method": Method.RSM_DISKS}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


@pytest.fixture(scope="module")
def truth(room: DeviceScene) -> Floats:
    return picture(room, **ONE_BOUNCE, method=Method.PATH, samples=256)


def test_one_bounce_is_that_of_path_tracing(room: DeviceScene, truth: Floats) -> None:
    clustered = picture(room, **RSM)
    assert clustered.mean() == pytest.approx(truth.mean(), rel=0.03)
    assert relative_error(clustered, truth) < 0.03
    assert picture(room, **RSM | {"bounces": 4}).tobytes() == clustered.tobytes()


def test_without_shadows_there_is_more_light_and_no_ray(room: DeviceScene, truth: Floats) -> None:
    frame = Renderer(room, SIZE, RenderSettings(**RSM, indirect_shadows=False)).render(pose(0))
    shadowed = Renderer(room, SIZE, RenderSettings(**RSM, near_field=False)).render(pose(0))
    assert frame.stats.counts["rays"] == frame.stats.counts["near"] == 0 < shadowed.stats.counts["rays"]
    assert frame.radiance().mean() > 1.02 * shadowed.radiance().mean()


def test_a_walk_keeps_its_clusters_and_traces_all_anew(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**RSM))
    walk = []
    for step in range(3):
        frame = renderer.render(pose(step), walks=True)
        walk.append(frame.radiance().tobytes())
        counts = frame.stats.counts
        assert counts["vpls"] == pytest.approx(64 * 64, rel=0.2)
        assert 50 < counts["vpl_clusters"] <= QUALITY["vpl_clusters"]
        assert counts["rays"] > 3000
        assert counts["unassigned"] == counts["nonfinite"] == frame.stats.skips["unchanged_lights"] == 0
    alone = Renderer(room, SIZE, RenderSettings(**RSM)).render(pose(2))
    assert alone.radiance().tobytes() != walk[2]
    again = Renderer(room, SIZE, RenderSettings(**RSM))
    assert [again.render(pose(step), walks=True).radiance().tobytes() for step in range(3)] == walk


def test_two_viewers_have_clusters_of_their_own(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**RSM))
    one, other = renderer.new_view(), renderer.new_view()
    walk = []
    for step in range(3):
        walk.append(renderer.render(pose(step), view=one, walks=True).radiance().tobytes())
        renderer.render(pose(20 + step), view=other, walks=True)
    alone = Renderer(room, SIZE, RenderSettings(**RSM))
    assert walk == [alone.render(pose(step), walks=True).radiance().tobytes() for step in range(3)]


def test_memory_is_told_of_as_many_maps_as_there_may_be() -> None:
    counts = sample_counts_of(RenderSettings(**RSM, shadow_map=128), wp.get_device("cpu"))
    (shared, view), (fuzzy, fuzzy_view) = RsmDisks.cluster_bytes(counts), FuzzyVpl.cluster_bytes(counts)
    vpls = 16 * 128 * 128
    assert 424 * vpls < shared - fuzzy < 474 * vpls  # 450 of one map beside arrays of other sizes
    assert view - fuzzy_view == 8 * counts.vpl_clusters
