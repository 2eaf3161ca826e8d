import numpy as np
import pytest
import warp as wp
from scenes import column, rectangle_over, results
from shadow_maps import COUNT, clustered, folded_floor, maps_of, seeds_of

from gpu.scene.types import Doubles
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.polygon_light import SIDES, Polygons, allocate_polygons, fit_polygons, polygon_irradiance
from gpu.vpl.vpl_clusters import VplClusters

CPU = wp.get_device("cpu")
UP, DOWN = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)


@wp.kernel
def polygon_light_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], polygons: Polygons,
                         vpls: VplClusters, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a point: the light of the first polygon."""
    point = first + wp.tid()
    out[point] = polygon_irradiance(position[point], normal[point], polygons, vpls, 0)


def lights() -> tuple[VplClusters, Polygons]:
    """Clusters of a floor and a wall, and their polygons."""
    maps = maps_of()
    vpls = folded_floor(maps)
    clustering, _ = clustered(maps, vpls, seeds_of(vpls))
    made = GroupLights(vpls.count, COUNT, clustering.device)
    made.run(vpls, clustering.groups, clustering.medoids)
    polygons = allocate_polygons(made.vpls, CPU)
    fit_polygons(made.vpls, polygons)
    return made.vpls, polygons


def rectangle(half_x: float, half_z: float) -> tuple[VplClusters, Polygons]:
    """One polygon, a rectangle about the origin that faces up and has the radiosity 1, as eight corners of it."""
    vpls, polygons = lights()
    turn = np.pi / 2.0 * (np.arange(SIDES) // 2) + np.pi / 4.0
    corners = np.stack([np.sign(np.cos(turn)) * half_x, 0.0 * turn, -np.sign(np.sin(turn)) * half_z], axis=1)
    polygons.corners.assign(np.repeat(corners[:, None], COUNT, axis=1).astype(np.float32))
    polygons.radiosity.fill_(wp.vec3(1.0, 1.0, 1.0))
    disks = vpls.disks.numpy().copy()
    disks["position"], disks["normal"] = 0.0, UP
    vpls.disks.assign(disks)
    return vpls, polygons


def light_at(position: Doubles, normal: Doubles, of: tuple[VplClusters, Polygons]) -> Doubles:
    inputs = [column(position, wp.vec3), column(normal, wp.vec3), of[1], of[0]]
    return results(polygon_light_kernel, len(position), inputs, wp.vec3)[:, 0]


def test_polygons_hold_all_members_and_have_their_flux() -> None:
    vpls, polygons = lights()
    starts, disks = vpls.starts.numpy(), vpls.disks.numpy()
    corners, members = polygons.corners.numpy().astype(np.float64), vpls.members.position.numpy()
    for cluster in np.flatnonzero(np.diff(starts)):
        own, normal = members[starts[cluster] : starts[cluster + 1]], disks["normal"][cluster]
        ring = corners[:, cluster]
        edges = np.roll(ring, -1, axis=0) - ring
        inwards = np.cross(normal, edges)
        inside = ((own[:, None] - ring[None]) * inwards[None]).sum(axis=2)
        assert (inside > 0.0).all()
        area = 0.5 * np.linalg.norm(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0))
        assert polygons.radiosity.numpy()[cluster] * area == pytest.approx(disks["flux"][cluster], rel=1e-3)
        # Half a member wider on each side: not far from the area of all members' disks, where these lie evenly.
        assert area < 6.0 * max(disks["area"][cluster], 1e-6) or len(own) < 8


def test_light_is_that_of_a_point_and_a_rectangle() -> None:
    heights = np.array([0.05, 0.3, 1.0, 4.0])
    position = np.stack([0.0 * heights, heights, 0.0 * heights], axis=1)
    found = light_at(position, np.tile(DOWN, (4, 1)), rectangle(0.4, 0.15))
    assert found == pytest.approx([rectangle_over(0.4, 0.15, height) for height in heights], rel=1e-3)
    assert (light_at(-position, np.tile(UP, (4, 1)), rectangle(0.4, 0.15)) == 0.0).all()


def test_what_lies_below_the_horizon_is_cut_off() -> None:
    """Points beside and above a rectangle, that look anywhere, by the light of many small parts."""
    rng, of = np.random.default_rng(0), rectangle(0.5, 0.3)
    position = rng.uniform([-0.6, 0.1, -0.6], [0.6, 0.5, 0.6], (40, 3))
    normal = rng.normal(size=(40, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    x, z = np.meshgrid((np.arange(200) + 0.5) / 200.0 - 0.5, ((np.arange(200) + 0.5) / 200.0 - 0.5) * 0.6)
    way = np.stack([x.ravel(), 0.0 * x.ravel(), z.ravel()], axis=1)[None] - position[:, None]
    squared = (way**2).sum(axis=2)
    cosines = np.maximum((way * normal[:, None]).sum(axis=2), 0.0) * -way[:, :, 1] / squared
    expected = (cosines / (np.pi * squared)).sum(axis=1) * 0.6 / 200.0**2
    assert light_at(position, normal, of) == pytest.approx(expected, rel=0.01, abs=1e-4)
    assert ((expected > 0.0) & (expected < 0.02)).any()
