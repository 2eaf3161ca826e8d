import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from pipeline import Pipeline, relative_error
from scenes import results, slats

from gpu.gbuffer import GBuffer
from gpu.scene.types import Doubles
from gpu.shade import CHECKS, Indirect
from gpu.transfer import unoccluded
from gpu.vpl_clusters import VplClusters


@wp.kernel
def light_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], vpls: VplClusters,
                 out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pair: what a VPL cluster sends an SP if nothing hides it."""
    pair = first + wp.tid()
    pixel = pixels[pair // vpls.count]
    out[pair] = unoccluded(gbuffer.position[pixel], gbuffer.normal[pixel], vpls, pair % vpls.count)


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    resident, camera, size = slats((24, 18))
    return Pipeline(resident, camera, size, sp_clusters=60)


def bits_of(fuzzy: Pipeline) -> NDArray[np.uint8]:
    """Visibility as (sp cluster, VPL cluster)."""
    words = fuzzy.visibility.words.numpy().astype("<u4").view(np.uint8)
    return np.unpackbits(words, axis=1, bitorder="little")[:, : fuzzy.lights.count]


def twin(fuzzy: Pipeline) -> tuple[Doubles, Doubles, Doubles]:
    """Equation 9 in NumPy: radiance (sp, 3), and the least and most brightness that one cluster alone would give."""
    count, lights = fuzzy.sp_count, fuzzy.lights.count
    sps = fuzzy.view.shading_points.pixels
    light = results(light_kernel, count * lights, [fuzzy.view.gbuffer, sps, fuzzy.lights], wp.vec3)
    light = light.reshape(count, lights, 3)
    clusters = fuzzy.clustering.clusters
    members, weights = clusters.cluster.numpy()[:, :count], clusters.weight.numpy()[:, :count].astype(np.float64)
    seen = bits_of(fuzzy)[members].astype(np.float64)  # (F, sp, VPL cluster)
    albedo = fuzzy.view.gbuffer.albedo.numpy()[fuzzy.pixels]
    alone = np.einsum("fsv,svc->fsc", seen, light) * albedo / np.pi
    brightness = np.where(weights > 0.0, alone.mean(axis=2), np.nan)
    return (alone * weights[..., None]).sum(axis=0), np.nanmin(brightness, axis=0), np.nanmax(brightness, axis=0)


def test_radiance_is_the_weighted_sum_over_the_clusters_of_an_sp(fuzzy: Pipeline) -> None:
    expected, low, high = twin(fuzzy)
    assert expected.max() > 0.0
    assert np.allclose(fuzzy.radiance()[fuzzy.pixels], expected, rtol=1e-3, atol=1e-6 * expected.max())
    indirect: Indirect = fuzzy.view.indirect
    assert np.allclose(indirect.low.numpy()[: fuzzy.sp_count], low, rtol=1e-3, atol=1e-6 * high.max())
    assert np.allclose(indirect.high.numpy()[: fuzzy.sp_count], high, rtol=1e-3, atol=1e-6 * high.max())
    assert (high > 1.05 * low).any()  # some clusters disagree, or the above says little


def test_words_are_drawn_in_proportion_to_their_light(fuzzy: Pipeline) -> None:
    words = fuzzy.view.indirect.word.numpy()[:, : fuzzy.sp_count]
    assert words.shape[0] == CHECKS
    count, lights = fuzzy.sp_count, fuzzy.lights.count
    light = results(light_kernel, count * lights, [fuzzy.view.gbuffer, fuzzy.view.shading_points.pixels, fuzzy.lights],
                    wp.vec3).reshape(count, lights, 3).mean(axis=2)  # fmt: skip
    clusters = fuzzy.clustering.clusters
    share = np.einsum("fs,fsv->sv", clusters.weight.numpy()[:, :count],
                      bits_of(fuzzy)[clusters.cluster.numpy()[:, :count]])  # fmt: skip
    amount = light * share
    starts = np.arange(0, lights, 32)
    amount = np.add.reduceat(amount, starts, axis=1)
    lit = amount.sum(axis=1) > 0.0
    expected = (amount[lit] / amount[lit].sum(axis=1, keepdims=True)).mean(axis=0)
    drawn = np.bincount(words[:, lit].ravel(), minlength=len(starts)) / words[:, lit].size
    assert np.allclose(drawn, expected, atol=0.05)
    assert len(expected) > 1


def test_gather_and_shade_agree_when_every_sp_is_a_cluster_of_its_own(fuzzy: Pipeline) -> None:
    own = Pipeline(fuzzy.resident, fuzzy.camera, fuzzy.size, sp_clusters=60, fuzziness=1)
    # Answers of rays from the SPs themselves, put where the clusters' answers stand.
    exact = own.exact()
    assert relative_error(own.radiance(), exact) > 1e-3
    count, view = own.sp_count, own.view
    each = np.stack([own.exact(vpl, vpl + 1) for vpl in range(own.lights.count)])
    seen = (each.mean(axis=2) > 0.0)[:, own.pixels].T
    padded = np.zeros((count, 32 * -(-own.lights.count // 32)), np.uint8)
    padded[:, : own.lights.count] = seen
    words = np.packbits(padded, axis=1, bitorder="little").view("<u4")
    own.visibility.words = wp.array(words, dtype=wp.uint32, device="cpu")
    clusters = own.clustering.clusters
    clusters.cluster = wp.array(np.arange(view.pixels)[None] % count, dtype=int, device="cpu")
    clusters.weight = wp.ones((1, view.pixels), dtype=float, device="cpu")
    own.shade()
    assert np.allclose(own.radiance(), exact, rtol=1e-3, atol=1e-5 * exact.max())


def test_runs_of_vpl_clusters_add_up(fuzzy: Pipeline) -> None:
    middle = fuzzy.lights.count // 2
    one, other = fuzzy.exact(0, middle), fuzzy.exact(middle)
    assert one.sum() > 0.0
    assert other.sum() > 0.0
    assert np.allclose(one + other, fuzzy.exact(), rtol=1e-5)
