"""Which pairs have rays: the plan of words of 32 VPL clusters against one made in plain Python."""

import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from numpy.typing import NDArray
from scenes import box, column, grey, quad, resident_of, results, strewn_vpls

from gpu.core.device import allocate, launch
from gpu.device_scene.features import EVERYTHING
from gpu.device_scene.rays import connection
from gpu.indirect.ray_plan import (
    ARRIVAL_RAYS,
    NO_LIGHT,
    PARTS,
    RAY_PLAN_PARAMETERS,
    RayPlan,
    Run,
    arriving_light_kernel,
    pair_light,
    pair_light_kernel,
    ray_list_kernel,
    ray_plan_kernel,
    weak_light_kernel,
    with_shared,
)
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.vpl_clusters import VplClusters

CPU = wp.get_device("cpu")
SPS, VPLS = 40, 150
WORDS = -(-VPLS // 32)


@wp.kernel
def each_pair_kernel(first: int, sps: SpClusters, vpls: VplClusters, out: wp.array[float]) -> None:
    """One thread a pair, (VPL cluster, representative)."""
    index = first + wp.tid()
    sp = index % sps.position.shape[0]
    out[index] = pair_light(sps.position[sp], sps.geometric_normal[sp], vpls, index // sps.position.shape[0])


@wp.kernel
def whole_kernel(first: int, plan: RayPlan, seen: wp.array[wp.uint32], out: wp.array[wp.uint32]) -> None:
    """One thread a word."""
    index = first + wp.tid()
    out[index] = with_shared(seen[index], plan, index)


@pytest.fixture(scope="module")
def vpls() -> VplClusters:
    clusters = cluster_vpls(resident_of(box(), [grey(0.5, 1.0)]), strewn_vpls(4000, 0.1, 7), VPLS, 0)
    assert 32 * (WORDS - 1) < clusters.count <= VPLS
    return clusters


@pytest.fixture(scope="module")
def sps() -> SpClusters:
    """Representatives here and there, all new, in the order of their numbers."""
    rng = np.random.default_rng(4)
    normals = rng.normal(size=(SPS, 3))
    clusters: SpClusters = allocate(SpClusters, SPS, CPU)
    clusters.position = column(rng.uniform(-0.5, 0.5, (SPS, 3)), wp.vec3)
    clusters.geometric_normal = column(normals / np.linalg.norm(normals, axis=1, keepdims=True), wp.vec3)
    clusters.order = column(np.arange(SPS), wp.int32)
    clusters.fresh = wp.full(1, SPS, dtype=int, device=CPU)
    return clusters


def pair_lights(sps: SpClusters, vpls: VplClusters) -> NDArray:
    """(VPL cluster, representative)."""
    return results(each_pair_kernel, SPS * vpls.count, [sps, vpls], float).reshape(vpls.count, SPS)


def part_lights(sps: SpClusters, vpls: VplClusters) -> tuple[wp.array, wp.array]:
    """The light of parts, and their picks."""
    parts, picks = (wp.zeros(int(PARTS) * SPS, dtype=kind, device=CPU) for kind in (float, int))
    launch(pair_light_kernel, int(PARTS) * SPS, [sps, vpls, parts, picks], CPU)
    return parts, picks


def weak_lights(sps: SpClusters, vpls: VplClusters, arrives: float = 1.0) -> wp.array:
    """arrives: the share of the light that does."""
    parts, _ = part_lights(sps, vpls)
    light = parts.numpy().reshape(-1, int(ARRIVAL_RAYS), SPS).sum(axis=0)
    arriving, weak = column(arrives * light.ravel(), float), wp.zeros(SPS, dtype=float, device=CPU)
    launch(weak_light_kernel, SPS, [sps, parts, arriving, RAY_PLAN_PARAMETERS, weak], CPU)
    return weak


def planned(sps: SpClusters, vpls: VplClusters, facing_away: bool, shared: bool) -> tuple[RayPlan, Run]:
    run, plan = Run(), allocate(RayPlan, WORDS * SPS, CPU)
    run.number, run.begin, run.most, run.words = 0, 0, SPS, WORDS
    launch(ray_plan_kernel(facing_away, shared), WORDS * SPS, [sps, vpls, run, weak_lights(sps, vpls), plan], CPU)
    return plan, run


def bits(words: wp.array) -> NDArray:
    """(word, representative, bit)."""
    return (words.numpy().reshape(WORDS, SPS, 1) >> np.arange(32, dtype=np.uint32) & 1).astype(bool)


def test_pairs_that_face_away_exchange_nothing(sps: SpClusters, vpls: VplClusters) -> None:
    light = pair_lights(sps, vpls)
    way = vpls.disks.numpy()["position"][:, None] - sps.position.numpy()
    behind = (way * sps.geometric_normal.numpy()).sum(axis=2) <= -1e-6
    sine = np.sqrt(np.maximum(1.0 - vpls.normal_cone_cos.numpy() ** 2, 0.0))[:, None]
    along = (way * vpls.disks.numpy()["normal"][:, None]).sum(axis=2)
    away = along >= sine * np.linalg.norm(way, axis=2) + 1e-6
    assert 0.2 < (behind | away).mean() < 0.8
    assert (light[behind | away] == float(NO_LIGHT)).all()
    assert (light == float(NO_LIGHT)).mean() < (behind | away).mean() + 0.01
    assert ((light >= 0.0) | (light == float(NO_LIGHT))).all()


def test_weak_is_what_sends_less_than_a_512th_of_all_light(sps: SpClusters, vpls: VplClusters) -> None:
    total = np.maximum(pair_lights(sps, vpls), 0.0).sum(axis=0)
    for arrives, share in ((1.0, 1.0), (0.3, 1.0), (0.1, 0.4), (0.0, 1.0 / 16.0)):
        assert weak_lights(sps, vpls, arrives).numpy() == pytest.approx(share * total / 512.0, rel=1e-4)


def test_a_few_rays_tell_how_much_light_arrives(sps: SpClusters, vpls: VplClusters) -> None:
    """Past a wall through the middle nothing does."""
    wall = resident_of([quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))], [grey(0.5)])
    parts, picks = part_lights(sps, vpls)
    light = np.maximum(pair_lights(sps, vpls), 0.0)
    arriving = wp.zeros(int(ARRIVAL_RAYS) * SPS, dtype=float, device=CPU)
    inputs = [wall.view(lambertian=True), sps, vpls, parts, picks, arriving]
    launch(arriving_light_kernel(EVERYTHING, connection(inputs[0])), int(ARRIVAL_RAYS) * SPS, inputs, CPU)
    same = (vpls.disks.numpy()["position"][: vpls.count, 2:] > 0.0) == (sps.position.numpy()[:, 2] > 0.0)
    total = np.maximum(light.sum(axis=0), 1e-30)  # some are behind all
    expected = (light * same).sum(axis=0) / total
    found = arriving.numpy().reshape(int(ARRIVAL_RAYS), SPS).sum(axis=0) / total
    assert 0.3 < expected.mean() < 0.9
    assert found.mean() == pytest.approx(expected.mean(), abs=0.06)
    # Of two, what sends nearly all has its back to them.
    assert np.quantile(np.abs(found - expected), 0.9) < 0.35


def test_clusters_are_asked_by_their_light(sps: SpClusters, vpls: VplClusters) -> None:
    """All representatives are the same, of those a part is asked once each."""
    count, one = 4000, sps
    many: SpClusters = allocate(SpClusters, count, CPU)
    many.position = column(np.repeat(one.position.numpy()[:1], count, axis=0), wp.vec3)
    many.geometric_normal = column(np.repeat(one.geometric_normal.numpy()[:1], count, axis=0), wp.vec3)
    many.order = column(np.arange(count), wp.int32)
    many.fresh = wp.full(1, count, dtype=int, device=CPU)
    parts, picks = (wp.zeros(int(PARTS) * count, dtype=kind, device=CPU) for kind in (float, int))
    launch(pair_light_kernel, int(PARTS) * count, [many, vpls, parts, picks], CPU)
    light = np.maximum(pair_lights(sps, vpls)[:, 0], 0.0)
    for part, asked in enumerate(picks.numpy().reshape(int(PARTS), count)):
        members = np.arange(part, vpls.count, int(PARTS))
        if light[members].sum() == 0.0:
            assert (asked == -1).all()
            continue
        share = light[members] / light[members].sum()
        found = (asked[:, None] == members).mean(axis=0)
        assert np.abs(found - share).max() < 5.0 * 0.5 / np.sqrt(count)


def test_rays_are_shared_by_weak_neighbours_alone(sps: SpClusters, vpls: VplClusters) -> None:
    plan, _ = planned(sps, vpls, facing_away=True, shared=True)
    light, weak = pair_lights(sps, vpls), weak_lights(sps, vpls).numpy()
    traced, shared = bits(plan.traced), bits(plan.shared)
    answers = 0
    for word in range(WORDS):
        for sp in range(SPS):
            own = np.full(32, -1.0)
            own[: min(32, vpls.count - 32 * word)] = light[32 * word : 32 * (word + 1), sp]
            faint = (own >= 0.0) & (own < weak[sp])
            rays, pool = (own >= 0.0) & ~faint, []
            leaders = {}
            for eight in range(4):
                members = [k for k in range(8 * eight, 8 * eight + 8) if faint[k]]
                if not members:
                    continue
                leaders[eight] = max(members, key=lambda k: own[k])
                if sum(own[members]) < weak[sp]:
                    pool.append(eight)
            if pool:
                brightest = max((leaders[eight] for eight in pool), key=lambda k: own[k])
                leaders.update(dict.fromkeys(pool, brightest))
            rays[list(leaders.values())] = True
            assert np.array_equal(traced[word, sp], rays)
            assert np.array_equal(shared[word, sp], faint & ~rays)
            packed = int(plan.leaders.numpy().reshape(WORDS, SPS)[word, sp])
            assert {eight: packed >> 8 * eight & 255 for eight in leaders} == leaders
            answers += int((faint & ~rays).sum())
    assert answers > 100


@pytest.mark.parametrize("facing_away", [False, True])
def test_without_sharing_each_pair_has_a_ray_of_its_own(sps: SpClusters, vpls: VplClusters, facing_away: bool) -> None:
    plan, _ = planned(sps, vpls, facing_away, shared=False)
    has_ray = bits(plan.traced).transpose(0, 2, 1).reshape(32 * WORDS, SPS)
    assert not has_ray[vpls.count :].any()
    expected = pair_lights(sps, vpls) >= 0.0 if facing_away else np.ones((vpls.count, SPS), bool)
    assert np.array_equal(has_ray[: vpls.count], expected)
    assert not plan.shared.numpy().any()


def test_rays_are_listed_word_by_word(sps: SpClusters, vpls: VplClusters) -> None:
    plan, run = planned(sps, vpls, facing_away=True, shared=True)
    traced, shared = bits(plan.traced).reshape(-1, 32), bits(plan.shared)
    rays, answers = wp.zeros(1, dtype=int, device=CPU), wp.zeros(1, dtype=int, device=CPU)
    pairs = wp.full(32 * WORDS * SPS, -1, dtype=int, device=CPU)
    launch(ray_list_kernel, WORDS * SPS, [sps, run, plan, rays, answers, pairs], CPU)
    assert rays.numpy()[0] == traced.sum()
    assert answers.numpy()[0] == shared.sum()
    listed = pairs.numpy()
    for word, begin in enumerate(plan.first_ray.numpy()):
        expected = 32 * word + np.flatnonzero(traced[word])
        assert np.array_equal(listed[begin : begin + len(expected)], expected)
    assert (listed[traced.sum() :] == -1).all()


def test_those_that_share_take_their_leaders_answer(sps: SpClusters, vpls: VplClusters) -> None:
    plan, _ = planned(sps, vpls, facing_away=True, shared=True)
    traced = plan.traced.numpy()
    seen = traced & np.random.default_rng(5).integers(0, 1 << 32, len(traced), dtype=np.uint32)
    inputs = [plan, column(seen, wp.uint32)]
    out = wp.zeros(len(traced), dtype=wp.uint32, device=CPU)
    launch(whole_kernel, len(traced), [*inputs, out], CPU)
    answer, own, shared = bits(out), bits(column(seen, wp.uint32)), bits(plan.shared)
    leaders = plan.leaders.numpy().reshape(WORDS, SPS, 1) >> np.repeat(8 * np.arange(4, dtype=np.uint32), 8) & 31
    assert np.array_equal(answer, own | (shared & np.take_along_axis(own, leaders.astype(np.int64), axis=2)))
    assert answer.sum() > own.sum()
