import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline
from scenes import slats

from gpu.core.device import launch
from gpu.core.kahan import Sum, kahan_add
from gpu.correction.vpl_connections import Connections, connect, drawn_member, member_probability
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import connected_solid
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.irradiance import CHECKS
from gpu.sampling.sobol import hashed
from gpu.scene.types import Doubles
from gpu.vpl.form_factor import member_irradiance
from gpu.vpl.shadow_rays import shadow_rays
from gpu.vpl.vpl_clusters import VplClusters

SIZE, SEEDS = (16, 12), 150
AREA = 2e-3


@wp.kernel
def all_members_kernel(first: int, scene: SceneData, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters,
                       areas: wp.array[float], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: its light of all VPLs, with a ray to each."""
    pixel = pixels[first + wp.tid()]
    position = gbuffer.position[pixel]
    total = Sum()
    for vpl in range(vpls.members.count):
        light = member_irradiance(position, gbuffer.normal[pixel], vpls, vpl, areas[vpl])
        there = vpls.members.position[vpl]
        facing = vpls.members.normal[vpl]
        if light[0] > 0.0 and connected_solid(scene, position, gbuffer.geometric_normal[pixel], there, facing):
            total = kahan_add(total, light)
    out[pixel] = total.total


@wp.kernel
def draw_kernel(first: int, position: wp.vec3, vpls: VplClusters, cluster: int, drawn: wp.array[int],
                probability: wp.array[float]) -> None:  # fmt: skip
    """One thread a draw of a member for an SP at `position`, and how probable that was."""
    index = first + wp.tid()
    normal = wp.vec3(0.0, 0.0, -1.0)
    areas = vpls.member_area
    vpl = drawn_member(position, normal, vpls, cluster, areas, hashed(wp.uint32(index)))
    drawn[index] = vpl
    probability[index] = member_probability(position, normal, vpls, cluster, areas, vpl, 0.0)


def areas_for(fuzzy: Pipeline) -> wp.array:
    """Another area for each VPL."""
    count = fuzzy.lights.members.count
    return wp.array(AREA * np.random.default_rng(0).uniform(0.2, 3.0, count), dtype=float, device="cpu")


def exact_light(fuzzy: Pipeline, areas: wp.array) -> Doubles:
    out, view = wp.zeros(fuzzy.view.pixels, dtype=wp.vec3, device="cpu"), fuzzy.view
    inputs = [view.scene, view.gbuffer, view.shading_points.pixels, fuzzy.lights, areas, out]
    launch(all_members_kernel, fuzzy.sp_count, inputs, view.device)
    return np.asarray(out.numpy(), np.float64)[fuzzy.pixels]


def connected_light(fuzzy: Pipeline, areas: wp.array, seeds: int, *, guided: bool = True) -> Doubles:
    """What rays find, (seed, sp, 3); guided: clusters know of some light."""
    view, found = fuzzy.view, []
    rays = shadow_rays(view.pixels, CHECKS, view.device, side_by_side=True, control_variate=False)
    for seed in range(seeds):
        fuzzy.shade(seed)
        if not guided:
            view.indirect.near_importance.zero_()
            view.indirect.far_importance.zero_()
        these = Connections()
        these.passes, these.seed, these.areas = 3, seed, areas
        connect(view.scene, view.gbuffer, view.shading_points, fuzzy.known, view.indirect, rays, these)
        found.append(np.asarray(view.indirect.irradiance.numpy(), np.float64)[fuzzy.pixels])
    return np.stack(found)


@pytest.mark.parametrize("far_field_sums", [False, True])
@pytest.mark.parametrize("beliefs", ["traced", "nonsense"])
def test_the_mean_is_the_light_of_all_vpls_whatever_clusters_believe(beliefs: str, far_field_sums: bool) -> None:
    device_scene, camera, _ = slats()
    fuzzy = Pipeline(device_scene, camera, SIZE, 80, vpls=1000, vpl_clusters=60, far_field_sums=far_field_sums)
    areas = areas_for(fuzzy)
    if beliefs == "nonsense":
        fuzzy.believe(np.random.default_rng(0).integers(0, 2, (fuzzy.clustering.count, fuzzy.lights.count)))
    exact, found = exact_light(fuzzy, areas), connected_light(fuzzy, areas, SEEDS)
    off = found.mean(axis=0) - exact
    whole = found.mean(axis=(1, 2)).std(ddof=1) / SEEDS**0.5
    assert abs(off.mean()) < 4.0 * whole < 0.02 * exact.mean()
    error = found.std(axis=0, ddof=1) / SEEDS**0.5 + 1e-3 * exact.mean()
    assert 0.6 < np.mean((off / error) ** 2) < 1.5


def test_of_what_no_cluster_knows_one_ray_to_the_likeliest_of_some_vpls_tells_much() -> None:
    """With half as many to choose from it would leave a quarter more noise, with twice as many not a fifth less."""
    device_scene, camera, _ = slats()
    fuzzy = Pipeline(device_scene, camera, SIZE, 80, vpls=1000, vpl_clusters=60, far_field_sums=True)
    areas = areas_for(fuzzy)
    exact, found = exact_light(fuzzy, areas), connected_light(fuzzy, areas, 60, guided=False)
    assert found.mean() == pytest.approx(exact.mean(), rel=0.03)
    noise = found.mean(axis=2).std(axis=0, ddof=1) / exact.mean(axis=1)
    assert 0.9 < noise.mean() < 1.1


def test_members_of_far_clusters_are_drawn_in_proportion_to_their_flux() -> None:
    device_scene, camera, _ = slats()
    vpls, draws = Pipeline(device_scene, camera, SIZE, 80, vpls=1000, vpl_clusters=60).lights, 20_000
    starts = vpls.starts.numpy()
    cluster = int(np.argmax(np.diff(starts[: vpls.count + 1])))
    members = range(starts[cluster], starts[cluster + 1])
    # Areas stand for flux.
    areas, share = vpls.member_area.numpy(), np.random.default_rng(0).dirichlet(np.full(len(members), 0.5))
    areas[members] = share * areas[members].sum()
    vpls.member_area.assign(areas)
    drawn, probability = (wp.zeros(draws, dtype=kind, device="cpu") for kind in (int, float))
    launch(draw_kernel, draws, [wp.vec3(0.0, 0.0, 50.0), vpls, cluster, drawn, probability], drawn.device)
    often = np.bincount(drawn.numpy() - members.start, minlength=len(members)) / draws
    assert np.all(np.abs(often - share) < 5.0 * np.sqrt((share + 1e-4) / draws))
    assert np.allclose(probability.numpy(), share[drawn.numpy() - members.start], rtol=1e-3)
