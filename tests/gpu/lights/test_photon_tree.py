import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA
from photons import photons_of, separations, two_sided_square
from scenes import column

from gpu.lights.photon_density import DENSITY_PARAMETERS, NEIGHBOURS, allocate_sites, estimate_density
from gpu.lights.photon_density import photon_density_kernel as search_kernel
from gpu.lights.photon_tree import allocate_tree, build_tree, direction_number, directions_about

CPU = wp.get_device("cpu")
COS = 0.8660254


@wp.kernel
def directions_kernel(normal: wp.array[wp.vec3], other: wp.array[wp.vec3], threshold: float, held: wp.array[int],
                      every: wp.array[int]) -> None:  # fmt: skip
    index = wp.tid()
    bits = directions_about(normal[index], threshold)
    held[index] = (bits >> direction_number(other[index])) & 1
    for number in range(27):
        every[index] += (bits >> number) & 1


def test_directions_about_a_normal_are_those_of_all_that_are_alike_and_few_others() -> None:
    normals, others = np.random.default_rng(3).normal(size=(2, 20_000, 3))
    others = normals + 0.4 * others
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    others /= np.linalg.norm(others, axis=1)[:, None]
    held, every = wp.zeros(20_000, dtype=int, device=CPU), wp.zeros(20_000, dtype=int, device=CPU)
    inputs = [column(normals, wp.vec3), column(others, wp.vec3), COS, held, every]
    wp.launch(directions_kernel, 20_000, inputs=inputs, device=CPU)
    alike = (normals * others).sum(axis=1) > COS
    assert 10_000 < alike.sum() < 18_000
    assert held.numpy()[alike].all()
    assert every.numpy().mean() < 9.0


@pytest.mark.parametrize("count", [3, 700])
def test_nodes_hold_what_their_runs_do(count: int) -> None:
    positions, normals = two_sided_square(count)
    fluxes = np.random.default_rng(1).uniform(size=(count, 3)).astype(np.float32)
    tree = allocate_tree(photons_of(positions, normals, fluxes))
    build_tree(tree)
    nodes, flow = tree.nodes.numpy(), tree.flow.numpy()
    for level in range(tree.levels + 1):
        for number in range(1 << level):
            run = slice(number * count >> level, (number + 1) * count >> level)
            node = (1 << level) + number
            assert nodes["photons"][node] == run.stop - run.start
            if run.stop > run.start:
                assert np.array_equal(nodes["lower"][node], positions[run].min(axis=0))
                assert np.array_equal(nodes["upper"][node], positions[run].max(axis=0))
            assert flow[node] == pytest.approx((normals[run] * fluxes[run].mean(axis=1)[:, None]).sum(axis=0), abs=1e-4)


@pytest.mark.parametrize(
    ("count", "usual", "levels"),
    [(3, None, 0), (60, None, 4), (300, None, 7), (700, None, 8), (700, 100, 5), (1800, None, 9)],
)
def test_the_search_finds_the_nearest_on_its_side(count: int, usual: int | None, levels: int) -> None:
    """In trees of any number of levels, also where there are more photons than usually."""
    positions, normals = two_sided_square(count)
    tree = allocate_tree(photons_of(positions, normals, np.ones((count, 3), np.float32)), usual)
    assert tree.levels == levels
    build_tree(tree)
    sites = allocate_sites(count, CPU)
    sites.photon.assign(np.arange(count, dtype=np.int32))
    sites.count.fill_(count)
    wp.launch(search_kernel, count, inputs=[0, 1, tree, DENSITY_PARAMETERS, sites], device=CPU)
    radius = sites.radius.numpy()
    for photon in range(0, count, 29):
        away = separations(positions[photon], normals[photon], positions, normals)
        away[photon] = np.inf
        wanted = min(np.sort(away)[:NEIGHBOURS][-1], DENSITY_PARAMETERS.most_radius)
        assert radius[photon] == pytest.approx(wanted, rel=1e-4)


@NEEDS_CUDA
def test_lanes_of_a_gpu_find_together_what_one_thread_does() -> None:
    count, device = 700, wp.get_device("cuda:0")
    photons = photons_of(*two_sided_square(count), np.random.default_rng(2).uniform(size=(count, 3)))
    for name in ("position", "normal", "flux", "bounce", "count"):
        setattr(photons, name, getattr(photons, name).to(device))
    tree = allocate_tree(photons)
    build_tree(tree)
    alone, together = allocate_sites(count, device), allocate_sites(count, device)
    for sites in (alone, together):
        sites.photon.assign(np.arange(count, dtype=np.int32))
        sites.count.fill_(count)
    wp.launch(search_kernel, count, inputs=[0, 1, tree, DENSITY_PARAMETERS, alone], device=device)
    estimate_density(tree, together)
    assert np.array_equal(together.radius.numpy(), alone.radius.numpy())
    assert np.allclose(together.irradiance.numpy(), alone.irradiance.numpy(), rtol=1e-5)
