import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA
from lit_surfaces import cluster_vpls
from pipeline import Pipeline
from scenes import column, results, slats, traced_vpls

from gpu.core.color import brightness
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.far_field import (
    FAR_FIELD_PARAMETERS,
    PARTS,
    FarFieldParameters,
    IrradianceGradient,
    visibility_weight,
    with_disk,
    with_subclusters,
)
from gpu.scene.types import Doubles
from gpu.vpl.disk_light import disk_at
from gpu.vpl.form_factor import disk_irradiance, is_opened
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def slope_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], vpls: VplClusters,
                 chosen: FarFieldParameters, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a point at a cluster: light, and its gradients by place and by normal."""
    index = first + wp.tid()
    point = index // vpls.count
    disk = disk_at(vpls.disks, index % vpls.count)
    slope = IrradianceGradient()
    if is_opened(position[point], disk):
        cluster = index % vpls.count
        slope = with_subclusters(slope, position[point], normal[point], vpls, cluster, 0, 1, chosen.grazing)
    else:
        slope = with_disk(slope, position[point], normal[point], disk, chosen.grazing)
    out[3 * index] = slope.light
    out[3 * index + 1] = slope.position_gradient
    out[3 * index + 2] = slope.normal_gradient


@wp.kernel
def unfolded_kernel(first: int, position: wp.array[wp.vec3], vpls: VplClusters, out: wp.array[int]) -> None:
    """One thread a point at a cluster: whether its one disk is too coarse there."""
    index = first + wp.tid()
    out[index] = int(is_opened(position[index // vpls.count], disk_at(vpls.disks, index % vpls.count)))


@wp.kernel
def brightness_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], vpls: VplClusters,
                      out: wp.array[float]) -> None:  # fmt: skip
    """One thread a point at a cluster: the brightness of its one disk."""
    index = first + wp.tid()
    point = index // vpls.count
    out[index] = brightness(disk_irradiance(position[point], normal[point], disk_at(vpls.disks, index % vpls.count)))


@wp.kernel
def doubt_kernel(first: int, share: wp.array[float], out: wp.array[float]) -> None:
    """One thread a share: the visibility_weight about it."""
    out[first + wp.tid()] = visibility_weight(share[first + wp.tid()])


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((48, 36))
    return Pipeline(device_scene, camera, size, sp_clusters=300, vpl_clusters=150, far_field_sums=True)


def slopes(fuzzy: Pipeline) -> Doubles:
    """Of each VPL cluster at each representative, (representative, VPL cluster, 3, 3)."""
    clusters, count = fuzzy.clustering.clusters, fuzzy.lights.count
    inputs = [clusters.position, clusters.normal, fuzzy.lights, FAR_FIELD_PARAMETERS]
    return results(slope_kernel, len(clusters.used) * count, inputs, wp.vec3, 3).reshape(-1, count, 3, 3)


def near_bits(fuzzy: Pipeline) -> Doubles:
    """Which VPL clusters are near each representative."""
    words = fuzzy.far.data.near.numpy().astype("<u4").view(np.uint8)
    return np.unpackbits(words, axis=1, bitorder="little")[:, : fuzzy.lights.count].astype(np.float64)


def test_near_clusters_are_those_within_three_spacings(fuzzy: Pipeline) -> None:
    clusters, disks = fuzzy.clustering.clusters, fuzzy.lights.disks.numpy()
    way = disks["position"][None] - clusters.position.numpy()[:, None]
    close = np.linalg.norm(way, axis=2) - disks["radius"] < 3.0 * clusters.spacing.numpy()[:, None]
    used = clusters.used.numpy() == 1
    near, lit = near_bits(fuzzy)[used] > 0.0, slopes(fuzzy)[used, :, 0].sum(axis=2) > 0.0
    assert not (near & ~close[used]).any()
    assert (near == close[used])[lit].mean() > 0.999  # rounding of a distance at the limit
    assert 0.005 < near.mean() < 0.2


def test_far_light_is_the_sum_of_what_is_seen_and_not_near(fuzzy: Pipeline) -> None:
    far, used = fuzzy.far.data, fuzzy.clustering.clusters.used.numpy() == 1
    seen = fuzzy.beliefs() * (1.0 - near_bits(fuzzy))
    expected = np.einsum("rv,rvkc->rkc", seen, slopes(fuzzy))[used]
    assert expected[:, 0].max() > 0.0
    for place, told in enumerate((far.light, far.position_gradient, far.normal_gradient)):
        scale = np.abs(expected[:, place]).max()
        assert np.allclose(told.numpy()[used], expected[:, place], rtol=1e-4, atol=1e-5 * scale)


def test_gradients_of_grazing_light_are_those_at_a_cosine_of_a_tenth(fuzzy: Pipeline) -> None:
    """One over a cosine is what light changes by as its surface turns: without bound at the horizon."""
    disk, up = fuzzy.lights.disks.numpy()[0], np.array([0.0, 1.0, 0.0])
    assert fuzzy.lights.count > 1
    for cosine, taken in ((0.3, 0.3), (0.03, 0.1)):
        side = np.cross(disk["normal"], up if abs(disk["normal"][1]) < 0.9 else np.array([1.0, 0.0, 0.0]))
        side /= np.linalg.norm(side)
        position = disk["position"] + 4.0 * disk["normal"]
        normal = -cosine * disk["normal"] + np.sqrt(1.0 - cosine**2) * side
        inputs = [column([position], wp.vec3), column([normal], wp.vec3), fuzzy.lights, FAR_FIELD_PARAMETERS]
        light, _, by_normal = results(slope_kernel, fuzzy.lights.count, inputs, wp.vec3, 3)[:3]
        assert np.linalg.norm(by_normal) == pytest.approx(light.mean() / taken, rel=1e-3)


def test_clusters_that_see_nothing_of_a_light_are_asked_a_quarter_as_often() -> None:
    weights = results(doubt_kernel, 3, [column([0.0, 0.5, 1.0], float)], float)
    assert weights == pytest.approx([0.25, 0.625, 1.0])


def test_masses_are_the_far_light_of_groups_and_parts_in_doubt_and_were_none_hidden(fuzzy: Pipeline) -> None:
    far, lights, used = fuzzy.far.data, fuzzy.lights, fuzzy.clustering.clusters.used.numpy() == 1
    doubts = results(doubt_kernel, 2, [column([0.0, 1.0], float)], float)
    amount = slopes(fuzzy)[:, :, 0].mean(axis=2) * (1.0 - near_bits(fuzzy))
    in_doubt = amount * doubts[fuzzy.beliefs().astype(int)]
    for light, importance, importance_cdf in (
        (in_doubt, far.weighted.importance, far.weighted.cdf),
        (amount, far.unoccluded.importance, far.unoccluded.cdf),
    ):
        groups = np.add.reduceat(light, lights.per_group * np.arange(lights.groups), axis=1)[used]
        assert groups.max() > 0.0
        assert np.allclose(importance.numpy()[: lights.groups, used].T, groups, rtol=1e-3, atol=1e-6 * groups.max())
        assert importance_cdf.shape[0] == PARTS
        sums = importance_cdf.numpy()[:, used]
        assert (np.diff(sums, axis=0) >= 0.0).all()
        assert np.allclose(sums[-1], groups.sum(axis=1), rtol=1e-3)
        assert np.allclose(sums[0], groups[:, 0], rtol=1e-3)


def test_gradients_are_those_of_finite_differences(fuzzy: Pipeline) -> None:
    clusters, count = fuzzy.clustering.clusters, fuzzy.lights.count
    place, normal = clusters.position.numpy().astype(np.float64), clusters.normal.numpy().astype(np.float64)

    def light(place: Doubles, normal: Doubles) -> Doubles:
        inputs = [column(place, wp.vec3), column(normal, wp.vec3), fuzzy.lights]
        return results(brightness_kernel, len(place) * count, inputs, float).reshape(len(place), count)

    inputs = [clusters.position, fuzzy.lights]
    coarse = results(unfolded_kernel, len(place) * count, inputs, wp.int32).reshape(len(place), count) == 1
    disks = fuzzy.lights.disks.numpy()
    way = disks["position"][None].astype(np.float64) - place[:, None]
    distance = np.linalg.norm(way, axis=2)
    facing = (way * normal[:, None]).sum(axis=2)
    leaving = -(way * disks["normal"][None]).sum(axis=2)
    # Where cosines are means over a disk or cone, the gradient is that of its middle alone.
    plain = (facing > disks["radius"] + 0.15 * distance) & (leaving > (disks["tilt"] + 0.15) * distance) & ~coarse
    plain &= near_bits(fuzzy) == 0.0
    assert plain.sum() > 1000
    slope = slopes(fuzzy)
    step = 1e-3
    for axis in np.eye(3):
        position_gradient = (light(place + step * axis, normal) - light(place - step * axis, normal)) / (2.0 * step)
        normal_gradient = (light(place, normal + step * axis) - light(place, normal - step * axis)) / (2.0 * step)
        assert np.allclose(
            slope[plain, 1] @ axis,
            position_gradient[plain],
            rtol=0.02,
            atol=2e-3 * np.abs(position_gradient[plain]).max(),
        )
        assert np.allclose(
            slope[plain, 2] @ axis, normal_gradient[plain], rtol=0.02, atol=2e-3 * np.abs(normal_gradient[plain]).max()
        )


def test_clusters_that_are_coarse_there_count_by_their_twigs(fuzzy: Pipeline) -> None:
    clusters, count = fuzzy.clustering.clusters, fuzzy.lights.count
    inputs = [clusters.position, clusters.normal, fuzzy.lights]
    number = len(clusters.used) * count
    coarse = results(unfolded_kernel, number, [clusters.position, fuzzy.lights], wp.int32).reshape(-1, count) == 1
    one = results(brightness_kernel, number, inputs, float).reshape(-1, count)
    told = slopes(fuzzy)[:, :, 0].mean(axis=2)
    assert np.allclose(told[~coarse], one[~coarse], rtol=1e-4)
    assert not np.allclose(told[coarse], one[coarse], rtol=0.1)


def sums_of(fuzzy: Pipeline) -> list[wp.array]:
    """What the representatives know of far light: by representative, then tables."""
    far = fuzzy.far.data
    tables = [far.weighted.importance, far.weighted.cdf, far.unoccluded.importance, far.unoccluded.cdf]
    return [far.light, far.position_gradient, far.normal_gradient, *tables]


@NEEDS_CUDA
def test_lanes_change_nothing_but_the_order_of_sums(fuzzy: Pipeline) -> None:
    device_scene = DeviceScene(fuzzy.device_scene.scene, wp.get_device("cuda:0"))
    alone = Pipeline(device_scene, fuzzy.camera, fuzzy.size, sp_clusters=300, vpl_clusters=150, far_field_sums=True)
    used = alone.clustering.clusters.used.numpy() == 1
    near, before = near_bits(alone), [array.numpy() for array in sums_of(alone)]
    alone.far.run(alone.clustering.clusters, alone.visibility.words, alone.lights, few=True)
    assert (near_bits(alone) == near)[used].all()
    for sums, those in zip(sums_of(alone), before, strict=True):
        rows = used if len(sums) == len(used) else (slice(None), used)
        assert np.allclose(sums.numpy()[rows], those[rows], rtol=1e-4, atol=1e-5 * np.abs(those[rows]).max())


def test_switched_off_all_clusters_are_near(fuzzy: Pipeline) -> None:
    whole = Pipeline(fuzzy.device_scene, fuzzy.camera, (24, 18), sp_clusters=60)
    used = whole.clustering.clusters.used.numpy() == 1
    assert near_bits(whole)[used].all()
    for sums in sums_of(whole):
        assert not sums.numpy().any()


def test_the_same_clusters_give_the_same_bits(fuzzy: Pipeline) -> None:
    before = fuzzy.irradiance().tobytes()
    fuzzy.shade()
    assert fuzzy.irradiance().tobytes() == before


def test_lights_with_fewer_clusters_leave_no_bits_behind_the_last(fuzzy: Pipeline) -> None:
    whole = Pipeline(fuzzy.device_scene, fuzzy.camera, (24, 18), sp_clusters=60, vpls=400, vpl_clusters=150)
    assert whole.lights.count > 100
    few = cluster_vpls(fuzzy.device_scene, traced_vpls(fuzzy.device_scene, whole.view.scene, 400, 3), 50, 1)
    whole.far.run(whole.clustering.clusters, whole.visibility.words, few, few=False)
    used = whole.clustering.clusters.used.numpy() == 1
    near = np.unpackbits(whole.far.data.near.numpy()[used].view(np.uint8), axis=1, bitorder="little")
    assert near[:, : few.count].all()
    assert not near[:, few.count :].any()
