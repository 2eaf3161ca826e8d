import numpy as np
import warp as wp
from scenes import grey, quad, resident_of

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.disk_coverage import surface_beside
from gpu.scene.types import Doubles


@wp.kernel
def places_kernel(scene: SceneData, position: wp.vec3, way: float, height: float, found: wp.array[int]) -> None:
    turn = 6.2831853 * float(wp.tid()) / float(found.shape[0])
    found[wp.tid()] = int(surface_beside(scene, position, wp.vec3(0.0, 1.0, 0.0), turn, way, height).face != NO_HIT)


def share(scene: SceneData, position: Doubles, way: float) -> float:
    """Of 64 places around one of the floor, those that are surface."""
    found = wp.zeros(64, dtype=int, device="cpu")
    wp.launch(places_kernel, 64, inputs=[scene, wp.vec3(*map(float, position)), way, 0.02, found], device="cpu")
    return float(found.numpy().mean())


def test_the_surface_ends_at_its_edge_and_at_a_wall() -> None:
    floor = quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    wall = quad((0.2, 0.0, -0.5), (0.0, 0.0, 1.0), (0.0, 0.5, 0.0))
    below = quad((-0.9, -0.1, -0.5), (0.0, 0.0, 1.0), (0.4, 0.0, 0.0))
    resident = resident_of([floor, wall, below], [grey(0.7)])
    scene, placement = resident.view(lambertian=True), resident.scene.placement
    edge, inner, foot = ((np.array([x, 0.0, 0.0]) - placement.centre) * placement.scale for x in (-0.5, -0.1, 0.2))
    assert share(scene, inner, 0.05) == 1.0
    assert 0.4 < share(scene, edge, 0.05) < 0.6  # what is below is too deep
    assert 0.4 < share(scene, foot - (1e-3, 0.0, 0.0), 0.05) < 0.6
    assert share(scene, inner, 0.0) == 0.0
