import numpy as np
import pytest
import warp as wp
from scenes import results
from shadow_maps import COUNT, again, clustered, folded_floor, maps_of, owners, seeds_of

from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.vpl_clusters import PER_SUBCLUSTER, VplClusters, out_of_reach


@wp.kernel
def group_light_kernel(first: int, vpls: VplClusters, out: wp.array[wp.vec3]) -> None:
    """One thread a cluster: its light at a point above the floor, that looks down; black if its group is not asked."""
    cluster = first + wp.tid()
    position = wp.vec3(0.4, 2.0, 0.2)
    down = wp.vec3(0.0, -1.0, 0.0)
    if not out_of_reach(position, down, vpls, cluster // vpls.per_group):
        out[cluster] = unoccluded_irradiance(position, down, vpls, cluster)


def test_disks_stand_for_the_members_of_clusters_in_every_round() -> None:
    maps = maps_of()
    vpls = folded_floor(maps)
    clustering, clusters = clustered(maps, vpls, seeds_of(vpls))
    lights = GroupLights(vpls.count, COUNT, clustering.device)
    for seed in (2, 3):
        again(clustering, clusters, vpls, np.repeat(seeds_of(vpls, COUNT // 2, seed), 2), begins=True)
        lights.run(vpls, clustering.groups, clustering.medoids)
        check(lights.vpls, owners(clustering), vpls.flux.numpy())


def check(lights: VplClusters, owner: np.ndarray, flux: np.ndarray) -> None:
    """Half of the clusters, twins of others, have no members."""
    starts, light = lights.starts.numpy(), results(group_light_kernel, COUNT, [lights], wp.vec3)
    empty = np.diff(starts) == 0
    assert empty.sum() == COUNT // 2
    assert (light[empty] == 0.0).all()
    # A floor that faces up lights what looks down on it, the wall beside it does not face there.
    total = sum(flux[owner == cluster].astype(np.float64).sum(axis=0) for cluster in range(COUNT))
    assert lights.members.flux.numpy()[: starts[-1]].sum(axis=0) == pytest.approx(total, rel=1e-5)
    disks = np.stack([lights.disks.numpy()[name] for name in ("flux", "normal", "position")], axis=1)
    for cluster in np.flatnonzero(~empty):
        assert disks[cluster, 0] == pytest.approx(flux[owner == cluster].sum(axis=0), rel=1e-4)
        way = np.array([0.4, 2.0, 0.2]) - disks[cluster, 2]
        squared, area = way @ way, lights.disks.numpy()["area"][cluster]
        expected = disks[cluster, 0] * max(way @ disks[cluster, 1], 0.0) * way[1]
        # The disk of Eq. 2 with its far limit: A·cosθ·cosθ′ / (π·d² + A).
        assert light[cluster] == pytest.approx(expected / (squared * (np.pi * squared + area)), rel=0.03, abs=1e-9)
    parts = -(-np.diff(starts) // int(PER_SUBCLUSTER))
    assert (lights.subcluster_starts.numpy() == np.append(0, np.cumsum(parts))).all()
    subclusters = lights.subclusters.numpy()["flux"][: parts.sum()]
    assert subclusters.sum(axis=0) == pytest.approx(total, rel=1e-4)
