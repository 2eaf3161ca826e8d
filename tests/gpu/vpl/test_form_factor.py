import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from scenes import box, column, grey, resident_of, results, square_of_vpls

from gpu.core.constants import PI
from gpu.core.device import allocate, launch
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.vpl.build import set_subclusters
from gpu.vpl.disk_light import Disk, disk_at, disk_of
from gpu.vpl.form_factor import (
    disk_area,
    disk_irradiance,
    disk_transfer,
    unoccluded_irradiance,
)
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters


@wp.kernel
def disk_kernel(first: int, way: wp.array[wp.vec3], area: float, out: wp.array[float]) -> None:
    """One thread a way to a disk that faces down, from a point that faces up."""
    index = first + wp.tid()
    out[index] = disk_transfer(way[index], wp.vec3(0.0, 0.0, 1.0), wp.vec3(0.0, 0.0, -1.0), area)


@wp.kernel
def unoccluded_kernel(first: int, vpls: VplClusters, out: wp.array[wp.vec3]) -> None:
    """One thread a cluster: its irradiance at the origin, which faces up."""
    cluster = first + wp.tid()
    out[cluster] = unoccluded_irradiance(wp.vec3(0.0, 0.0, 0.0), wp.vec3(0.0, 0.0, 1.0), vpls, cluster)


@pytest.mark.parametrize("height", [0.01, 0.3, 5.0])
def test_on_its_axis_a_disk_transfers_its_form_factor(height: float) -> None:
    area = 0.25
    way = column([[0.0, 0.0, height]], wp.vec3)
    (transferred,) = results(disk_kernel, 1, [way, area], float)
    radius_squared = area / np.pi
    assert transferred * area == pytest.approx(radius_squared / (radius_squared + height**2), rel=1e-5)


def test_transfer_is_bounded_and_one_sided() -> None:
    rng = np.random.default_rng(1)
    ways = rng.normal(size=(1000, 3)) * np.exp(rng.uniform(-20, 2, (1000, 1)))
    transferred = results(disk_kernel, 1000, [column(ways, wp.vec3), 0.5], float)
    assert np.isfinite(transferred).all()
    assert (transferred <= 1.0 / 0.5 + 1e-5).all()
    assert (transferred[ways[:, 2] <= 0.0] == 0.0).all()


@wp.kernel
def disk_kernel_of(first: int, position: wp.vec3, normal: wp.vec3, area: float, normal_cone_cos: float,
                   out: wp.array[Disk]) -> None:  # fmt: skip
    """One thread: the disk of a cluster."""
    out[first + wp.tid()] = disk_of(
        position, normal, wp.vec3(10.0, 8.0, 12.0), area, area / (2.0 * PI), normal_cone_cos
    )


@wp.kernel
def downward_kernel(first: int, vpls: VplClusters, out: wp.array[wp.vec3]) -> None:
    """One thread a cluster: its irradiance at the origin, which faces down."""
    cluster = first + wp.tid()
    out[cluster] = unoccluded_irradiance(wp.vec3(0.0, 0.0, 0.0), wp.vec3(0.0, -1.0, 0.0), vpls, cluster)


@wp.kernel
def area_kernel(first: int, vpls: VplClusters, position: wp.array[wp.vec3], out: wp.array[float]) -> None:
    """One thread a point: the area of the disk as part of which VPL 9 lights it."""
    index = first + wp.tid()
    out[index] = disk_area(position[index], vpls, 9)


@wp.kernel
def tilted_kernel(first: int, vpls: VplClusters, normals: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:
    """One thread a normal: the irradiance from cluster 0 at the origin with that normal."""
    index = first + wp.tid()
    out[index] = disk_irradiance(wp.vec3(0.0, 0.0, 0.0), normals[index], disk_at(vpls.disks, 0))


def cluster_above(
    height: float, area: float, normal_cone_cos: float = 1.0, normal: tuple[float, float, float] = (0.0, 0.0, -1.0)
) -> VplClusters:
    """A cluster of four VPLs around (0, 0, height) that face down, of a cone of normals given by its cosine."""
    device = wp.get_device("cpu")
    members: Vpls = allocate_vpls(4, device)
    members.position = column([[x, y, height] for x in (-0.1, 0.1) for y in (-0.1, 0.1)], wp.vec3)
    members.normal = column([[0.0, 0.0, -1.0]] * 4, wp.vec3)
    members.flux = column([[k, 2.0, 3.0] for k in range(1, 5)], wp.vec3)
    clusters: VplClusters = allocate(VplClusters, 1, device)
    clusters.count, clusters.members, clusters.path_flux = 1, members, members.flux
    launch(
        disk_kernel_of, 1, [wp.vec3(0.0, 0.0, height), wp.vec3(*normal), area, normal_cone_cos, clusters.disks], device
    )
    clusters.normal_cone_cos, clusters.extent = column([normal_cone_cos], float), column([0.15], float)
    clusters.starts, clusters.member_area = column([0, 4], wp.int32), column([area / 4.0] * 4, float)
    set_subclusters(clusters, clusters.starts.numpy(), device)
    return clusters


def test_far_away_a_cluster_counts_as_one_disk() -> None:
    light = results(unoccluded_kernel, 1, [cluster_above(4.0, 0.04)], wp.vec3).ravel()
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) / (np.pi * 16.0 + 0.04), rel=1e-5)


def test_near_by_its_members_count_one_by_one() -> None:
    height, area = 0.1, 0.04
    light = results(unoccluded_kernel, 1, [cluster_above(height, area)], wp.vec3).ravel()
    squared = 0.02 + height**2
    each = height * height / (squared * (np.pi * squared + area / 4))
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) * each, rel=1e-4)


def test_near_by_disks_are_those_of_twigs_and_then_of_members() -> None:
    device_scene = resident_of(box(), [grey(0.5, 1.0)])
    clusters = cluster_vpls(device_scene, square_of_vpls(400), 1, 0)
    whole, subcluster = clusters.disks.numpy()[0], clusters.subclusters.numpy()[9 // int(PER_SUBCLUSTER)]
    reaches = [disk["radius"] / np.sqrt(share) for disk, share in ((whole, 0.167), (subcluster, 0.05))]
    points = [disk["position"] + [0.0, share * reach, 0.0]
              for disk, reach in zip((whole, subcluster), reaches, strict=True) for share in (1.01, 0.99)]  # fmt: skip
    areas = results(area_kernel, 4, [clusters, column(points, wp.vec3)], float)
    number = int(PER_SUBCLUSTER)
    own = clusters.member_area.numpy()
    eight = own[9 // number * number :][:number].sum()
    assert areas == pytest.approx([whole["area"], eight, eight, own[9]], rel=1e-4)


def test_twigs_stand_for_their_members() -> None:
    """From near the whole cluster, but not near any of its members, subclusters make no difference."""
    device_scene = resident_of(box(), [grey(0.5, 1.0)])
    clusters = cluster_vpls(device_scene, square_of_vpls(4096, height=-0.4, seed=3), 1, 0)
    members = clusters.members
    way = members.position.numpy().astype(np.float64)
    squared, area = (way**2).sum(axis=1), clusters.disks.numpy()["area"][0] / 4096
    share = np.maximum(-way[:, 1], 0.0) ** 2 / (squared * (np.pi * squared + int(PER_SUBCLUSTER) * area))
    expected = (members.flux.numpy() * share[:, None]).sum(axis=0)
    light = results(downward_kernel, 1, [clusters], wp.vec3).ravel()
    assert light == pytest.approx(expected, rel=2e-3)


def mean_of_disk(height: float, area: float, normal_cosine: float, samples: int = 200_000) -> float:
    """Mean of max(cosθ, 0)·d over an even disk at a height, for a receiver that is tilted from facing it."""
    rng = np.random.default_rng(0)
    radius, angle = np.sqrt(rng.uniform(0.0, area / np.pi, samples)), rng.uniform(0.0, 2.0 * np.pi, samples)
    facing = height * np.cos(normal_cosine) + radius * np.cos(angle) * np.sin(normal_cosine)
    return float(np.maximum(facing, 0.0).mean())


@pytest.mark.parametrize("degrees", [0.0, 40.0, 75.0, 85.0, 90.0, 95.0, 120.0])
def test_a_disk_on_the_horizon_lights_with_what_is_above_it(degrees: float) -> None:
    height, area, normal_cosine = 1.0, 0.3, np.radians(degrees)
    normal = column([[np.sin(normal_cosine), 0.0, np.cos(normal_cosine)]], wp.vec3)
    light = results(tilted_kernel, 1, [cluster_above(height, area), normal], wp.vec3).reshape(3)
    expected = mean_of_disk(height, area, normal_cosine) * height / (height**2 * (np.pi * height**2 + area))
    # An even spread stands for the disk's.
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) * expected, rel=0.02, abs=0.002)
    assert (light[0] > 0.0) == (degrees <= 95.0)


def test_members_whose_normals_stray_light_what_their_cluster_faces_away_from() -> None:
    up = column([[0.0, 0.0, 1.0]], wp.vec3)
    for tilt, reaches in ((0.0, False), (0.3, False), (0.8, True)):
        # It leans away from the origin, by 100° from the way there.
        away = np.radians(100.0)
        cluster = cluster_above(1.0, 0.0, np.cos(tilt), (np.sin(away), 0.0, -np.cos(away)))
        light = results(tilted_kernel, 1, [cluster, up], wp.vec3)
        assert (light.sum() > 0.0) == reaches
