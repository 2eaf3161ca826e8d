import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from pipeline import Pipeline
from scenes import box, grey, resident_of, results, slats, square_of_vpls
from scipy import stats

from gpu.core.color import brightness
from gpu.correction.vpl_sampling import VPL_SAMPLE_PARAMETERS, VplSampleParameters, member_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.sampling.sobol import hashed
from gpu.vpl.form_factor import member_irradiance
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def member_share_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters, seed: int,
                        limits: VplSampleParameters, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pair of an SP and a VPL cluster: the member that is drawn, its share, and the cluster's light."""
    pair = first + wp.tid()
    pixel = pixels[pair // vpls.count]
    state = wp.uint32(pair) * wp.uint32(747796405) + wp.uint32(seed)
    sample = member_of(gbuffer.position[pixel], gbuffer.normal[pixel], vpls, pair % vpls.count, state, limits)
    out[pair] = wp.vec3(float(sample.vpl), sample.share, sample.whole)


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((24, 18))
    return Pipeline(device_scene, camera, size, sp_clusters=20)


def test_a_member_is_of_its_cluster_and_counts_at_most_four_times_what_that_lets_expect(fuzzy: Pipeline) -> None:
    view, lights, count = fuzzy.view, fuzzy.lights, fuzzy.sp_count
    inputs = [view.gbuffer, view.shading_points.pixels, lights, 1, VPL_SAMPLE_PARAMETERS]
    drawn = results(member_share_kernel, count * lights.count, inputs, wp.vec3).reshape(count, lights.count, 3)
    starts = lights.starts.numpy()
    assert (drawn[..., 0] >= starts[:-1]).all()
    assert (drawn[..., 0] < starts[1:]).all()
    lit = drawn[..., 2] > 0.0
    assert drawn[..., 1][lit].max() == pytest.approx(4.0)
    assert np.mean(drawn[..., 1][lit] == drawn[..., 1][lit].max()) < 0.05


def test_members_send_in_the_mean_what_their_cluster_lets_expect(fuzzy: Pipeline) -> None:
    view, lights, count = fuzzy.view, fuzzy.lights, fuzzy.sp_count
    shares = []
    for seed in range(100):
        inputs = [view.gbuffer, view.shading_points.pixels, lights, seed, VPL_SAMPLE_PARAMETERS]
        shares.append(results(member_share_kernel, count * lights.count, inputs, wp.vec3))
    drawn = np.stack(shares)
    lit = drawn[0, :, 2] > 0.0
    sent = (drawn[:, lit, 1] * drawn[:, lit, 2]).mean(axis=0).sum()
    assert sent == pytest.approx(drawn[0, lit, 2].sum(), rel=0.05)


@wp.kernel
def member_light_kernel(first: int, position: wp.vec3, normal: wp.vec3, vpls: VplClusters,
                        out: wp.array[float]) -> None:  # fmt: skip
    """One thread a member of the only cluster: its light where members are shaded one by one."""
    member = first + wp.tid()
    area = vpls.disks[0].area / float(vpls.members.count)
    out[member] = brightness(member_irradiance(position, normal, vpls, member, area))


@wp.kernel
def draw_member_kernel(first: int, position: wp.vec3, normal: wp.vec3, vpls: VplClusters,
                       limits: VplSampleParameters, out: wp.array[int]) -> None:  # fmt: skip
    """One thread a draw of a member of the only cluster."""
    draw = first + wp.tid()
    out[draw] = member_of(position, normal, vpls, 0, hashed(wp.uint32(draw)), limits).vpl


@pytest.mark.parametrize("height", [0.05, 50.0])
def test_members_are_drawn_by_their_light_near_a_cluster_and_by_flux_far_away(height: float) -> None:
    vpls = cluster_vpls(resident_of(box(), [grey(0.5)]), square_of_vpls(8), 1, 0)
    assert (vpls.count, vpls.members.count) == (1, 4)
    inputs = [wp.vec3(0.05, height, 0.02), wp.vec3(0.0, -1.0, 0.0), vpls]
    light = results(member_light_kernel, 4, inputs, float)
    expected = light if height < 1.0 else vpls.members.flux.numpy().astype(np.float64).mean(axis=1)
    counts = np.bincount(
        results(draw_member_kernel, 20_000, [*inputs, VPL_SAMPLE_PARAMETERS], wp.int32).astype(int), minlength=4
    )
    assert stats.chisquare(counts, expected / expected.sum() * 20_000).pvalue > 1e-3
    assert light.max() > 1.2 * light.min()
