import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from lit_surfaces import cluster_vpls
from numpy.typing import NDArray
from scenes import results, slats, traced_vpls

from gpu.core.color import brightness
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connected_solid
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.visibility import Visibility
from gpu.sp.sp_clustering import SpClustering
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def pair_kernel(first: int, scene: SceneData, p: wp.array[wp.vec3], p_normal: wp.array[wp.vec3], vpls: VplClusters,
                seen: wp.array[int]) -> None:  # fmt: skip
    """One thread a pair: the plain answer."""
    pair = first + wp.tid()
    sp = pair // vpls.count
    vpl = pair % vpls.count
    disk = disk_at(vpls.disks, vpl)
    seen[pair] = int(connected_solid(scene, p[sp], p_normal[sp], disk.position, disk.normal))


@wp.kernel
def light_kernel(first: int, p: wp.array[wp.vec3], p_normal: wp.array[wp.vec3], vpls: VplClusters,
                 out: wp.array[float]) -> None:  # fmt: skip
    """One thread a pair: the brightness that the VPL cluster sends."""
    pair = first + wp.tid()
    sp = pair // vpls.count
    out[pair] = brightness(disk_irradiance(p[sp], p_normal[sp], disk_at(vpls.disks, pair % vpls.count)))


@pytest.fixture(scope="module")
def traced() -> tuple[DeviceScene, FrameView, SpClustering, VplClusters]:
    device_scene, camera, size = slats()
    view = FrameView(device_scene, size, lambertian=True)
    view.set_camera(camera)
    view.find_shading_points()
    clustering = SpClustering(view.shading_points, 90, 6, by_distance=True)
    clustering.run(view.gbuffer, 0)
    vpls = traced_vpls(device_scene, view.scene, 3000, 3)
    return device_scene, view, clustering, cluster_vpls(device_scene, vpls, 150, 0)


def bits_of(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters], **skips: bool
) -> tuple[NDArray, Visibility]:
    """What the stage says of each pair, (sp cluster, vpl cluster); skips: as for Visibility."""
    _, view, clustering, vpls = traced
    stage = Visibility(clustering.count, vpls.count, view.device, **skips)
    stage.trace(view.scene, clustering.clusters, vpls)
    bytes_ = stage.words.numpy().astype("<u4").view(np.uint8)
    return np.unpackbits(bytes_, axis=1, bitorder="little")[:, : vpls.count], stage


def exact_bits(traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters]) -> NDArray:
    """A ray for every pair."""
    _, view, clustering, vpls = traced
    clusters = clustering.clusters
    pairs = clustering.count * vpls.count
    seen = results(pair_kernel, pairs, [view.scene, clusters.position, clusters.geometric_normal, vpls], wp.int32)
    return seen.reshape(clustering.count, vpls.count) * clusters.used.numpy()[:, None]


def facing(traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters]) -> NDArray:
    """Whether each pair can exchange light by its normals: points of one plane cannot, though nothing is between."""
    _, _, clustering, vpls = traced
    way = vpls.disks.numpy()["position"][None] - clustering.clusters.position.numpy()[:, None]
    here = (way * clustering.clusters.geometric_normal.numpy()[:, None]).sum(axis=2)
    return (here > 1e-5) & (-(way * vpls.disks.numpy()["normal"][None]).sum(axis=2) > 1e-5)


def light(traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters]) -> NDArray:
    """What each VPL cluster sends each representative if nothing is between them."""
    _, _, clustering, vpls = traced
    clusters = clustering.clusters
    inputs = [clusters.position, clusters.geometric_normal, vpls]
    return results(light_kernel, clustering.count * vpls.count, inputs, float).reshape(clustering.count, vpls.count)


def vpl_count(traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters]) -> int:
    return int(traced[3].count)


def test_most_answers_are_exact_and_those_shared_are_of_weak_pairs(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters],
) -> None:
    bits, stage = bits_of(traced)
    exact = exact_bits(traced)
    sent = light(traced)
    wrong = (bits != exact) & facing(traced)
    assert wrong.sum() > 10  # else nothing was shared, and this test is of nothing
    rays, shared = stage.rays.numpy().sum(), stage.shared.numpy().sum()
    assert 0 < rays < rays + shared < bits.size
    assert wrong.sum() <= shared
    # The bounds that gpu.indirect.visibility states, of each pair and of eight neighbours; and how it is on the whole.
    whole = sent.sum(axis=1, keepdims=True)
    assert (wrong * sent <= 1.001 / 512.0 * whole).all()
    groups = np.add.reduceat(wrong * sent, np.arange(0, vpl_count(traced), 8), axis=1)
    assert (groups <= 7.007 / 512.0 * whole).all()
    assert (wrong * sent).sum() < 0.06 * sent.sum()
    off = ((bits.astype(int) - exact) * facing(traced) * sent).sum(axis=1) / whole[:, 0]
    assert np.sqrt(np.mean(off**2)) < 0.03


def test_without_sharing_every_answer_is_exact(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters],
) -> None:
    bits, stage = bits_of(traced, shared_weak_rays=False)
    pairs = facing(traced)
    assert pairs.sum() > 1000
    assert np.array_equal(bits[pairs], exact_bits(traced)[pairs])
    assert stage.shared.numpy().sum() == 0


@pytest.mark.parametrize("skips", [{}, {"shared_weak_rays": False}, {"shared_weak_rays": False, "facing_away": False}])
def test_runs_of_representatives_give_what_all_at_once_give(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters],
    skips: dict[str, bool],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bits, stage = bits_of(traced, **skips)
    monkeypatch.setattr("gpu.indirect.visibility.MAX_PAIRS", 2 * 32 * traced[2].count)  # two fifths at a time
    other, in_runs = bits_of(traced, **skips)
    assert np.array_equal(other, bits)
    assert len(in_runs.rays) > len(stage.rays) == 1
    assert in_runs.rays.numpy().sum() == stage.rays.numpy().sum()
    assert in_runs.shared.numpy().sum() == stage.shared.numpy().sum()


def test_more_rays_than_threads_are_all_traced(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters], monkeypatch: pytest.MonkeyPatch
) -> None:
    bits, stage = bits_of(traced)
    for blocks in ("MOST_BLOCKS", "FEW_BLOCKS"):
        monkeypatch.setattr(f"gpu.indirect.visibility.{blocks}", 1)
    assert stage.rays.numpy().sum() > 1000
    assert np.array_equal(bits_of(traced)[0], bits)
    monkeypatch.setattr("gpu.indirect.visibility.MAX_PAIRS", 2 * 32 * traced[2].count)
    assert np.array_equal(bits_of(traced)[0], bits)


def test_a_stage_for_more_vpl_clusters_than_there_are_sees_none_beyond(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters],
) -> None:
    _, view, clustering, vpls = traced
    stage = Visibility(clustering.count, vpls.count + 200, view.device)
    stage.trace(view.scene, clustering.clusters, vpls)
    words, full = stage.words.numpy(), vpls.count // 32
    assert (words[:, :full] != 0).any(axis=0).all()
    assert (words[:, full] >> (vpls.count - 32 * full) == 0).all()
    assert (words[:, full + 1 :] == 0).all()
    assert stage.rays.numpy().sum() == bits_of(traced)[1].rays.numpy().sum()


def test_pairs_that_face_away_exchange_hardly_any_light_whatever_a_ray_would_find(
    traced: tuple[DeviceScene, FrameView, SpClustering, VplClusters],
) -> None:
    bits, stage = bits_of(traced, shared_weak_rays=False)
    other, all_emitters = bits_of(traced, shared_weak_rays=False, facing_away=False)
    used = traced[2].clusters.used.numpy().sum()
    assert all_emitters.rays.numpy().sum() == used * vpl_count(traced)
    assert stage.rays.numpy().sum() < 0.8 * all_emitters.rays.numpy().sum()
    changed = bits != other
    assert (other >= bits).all()
    # But for what a disk sends over a horizon that its representative is behind.
    assert (changed * light(traced)).sum() < 1e-6 * light(traced).sum()
