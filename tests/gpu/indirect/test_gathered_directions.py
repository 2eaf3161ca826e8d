import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.core.device import allocate, launch
from gpu.device_scene.features import EVERYTHING
from gpu.gbuffer.gbuffer import allocate_gbuffer
from gpu.indirect.final_gather import Gathered
from gpu.indirect.gather_rays import coherent_order, gather_direction
from gpu.indirect.gathered_directions import glossy_receivers, project_radiance
from gpu.indirect.guided_rays import GuidedRays
from gpu.indirect.spherical_harmonics import Harmonics, harmonics_at
from gpu.sp.centres import ShadingClusters

CPU = wp.get_device("cpu")
RAYS, UP = 256, (0.0, 1.0, 0.0)


@wp.kernel
def fill_kernel(
    first: int, clusters: ShadingClusters, order: wp.array[int], seeds: wp.array[int], out: Gathered
) -> None:
    """One thread a ray of the first cluster: finds 2 + x in red, 1 in green and nothing in blue."""
    place = first + wp.tid()
    direction = gather_direction(clusters, order, seeds, 0, place)
    out.radiance[place] = wp.vec3(2.0 + direction[0], 1.0, 0.0)


@wp.kernel
def direction_kernel(
    first: int, clusters: ShadingClusters, order: wp.array[int], seeds: wp.array[int], out: GuidedRays
) -> None:
    """One thread a ray of the first cluster: its direction."""
    place = first + wp.tid()
    out.direction[place] = gather_direction(clusters, order, seeds, 0, place)


@wp.kernel
def read_kernel(first: int, coefficients: wp.array2d[Harmonics], directions: wp.array[wp.vec3],
                out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    values = harmonics_at(directions[index])
    for channel in range(3):
        out[index][channel] = wp.dot(coefficients[0, channel], values)


@pytest.mark.parametrize("guided", [False, True])
def test_coefficients_tell_what_rays_found_in_all_directions_above(guided: bool) -> None:
    """guided: what is found along the rays of a centre's own is found along guided ones instead."""
    clusters: ShadingClusters = allocate(ShadingClusters, 2, CPU)
    clusters.normal, clusters.spacing = column([UP, UP], wp.vec3), column([0.1, 0.0], float)
    gathered: Gathered = allocate(Gathered, 2, CPU)
    gathered.radiance = wp.full(2 * RAYS, wp.vec3(9.0, 9.0, 9.0), dtype=wp.vec3, device=CPU)
    order, seed = wp.array(coherent_order(RAYS), dtype=int, device=CPU), wp.zeros(1, dtype=int, device=CPU)
    launch(fill_kernel, RAYS, [clusters, order, seed, gathered], CPU)
    irradiance = gathered.radiance.numpy()[:RAYS].mean(axis=0) * np.pi
    gathered.irradiance = column([irradiance, irradiance], wp.vec3)
    if guided:
        gathered.guided.radiance = wp.clone(gathered.radiance)
        gathered.guided.direction = wp.zeros(2 * RAYS, dtype=wp.vec3, device=CPU)
        launch(direction_kernel, RAYS, [clusters, order, seed, gathered.guided], CPU)
        gathered.radiance.zero_()
    receivers = glossy_receivers(allocate_gbuffer(1, CPU, EVERYTHING), 2)
    project_radiance(clusters, order, seed, gathered, receivers.coefficients)
    assert not receivers.coefficients.numpy()[1].any()
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(50, 3))
    directions[:, 1] = np.abs(directions[:, 1])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    out = wp.zeros(50, dtype=wp.vec3, device=CPU)
    launch(read_kernel, 50, [receivers.coefficients, column(directions, wp.vec3), out], CPU)
    told = out.numpy()
    assert told[:, 0] == pytest.approx(2.0 + directions[:, 0], abs=0.25)
    assert told[:, 1] == pytest.approx(1.0, rel=0.2 if guided else 1e-3)
    assert told[:, 2] == pytest.approx(0.0, abs=1e-6)
