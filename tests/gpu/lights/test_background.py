"""What is seen behind every surface."""

import numpy as np
import pytest
import warp as wp
from scenes import column, quad, results, scene_of
from trimesh.creation import icosphere

from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import closest_hit, occluded, seen_hit
from gpu.device_scene.upload import DeviceScene
from gpu.lights.background import background
from gpu.lights.build import build_light_table
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Light, LightKind, Material

GROUND = quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0], 0)
SUN = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, -1.0, 0.0))
COUNT = 1 << 12


@wp.kernel
def behind_kernel(first: int, scene: SceneData, ways: wp.array[wp.vec3], out: wp.array[wp.vec4]) -> None:
    """What is seen behind from above the ground, and 1 for each kind of ray that meets something there."""
    index = first + wp.tid()
    origin = wp.vec3(0.0, 0.1, 0.0)
    colour = background(scene, origin, ways[index])
    met = float(int(occluded(scene, origin, ways[index], 1.0e6)))
    if seen_hit(scene, origin, ways[index]).face >= 0 or closest_hit(scene, origin, ways[index], 1.0e6).face >= 0:
        met += 2.0
    out[index] = wp.vec4(colour[0], colour[1], colour[2], met)


@wp.kernel
def irradiance_kernel(first: int, scene: SceneData, table: LightTable, out: wp.array[wp.vec3]) -> None:
    """Irradiance above the ground from light samples, and by rays that meet light: an estimate each."""
    index = first + wp.tid()
    position = wp.vec3(0.0, 0.1, 0.0)
    pick = sobol_pair(index, 0, 3)
    place = sobol_pair(index, 1, 3)
    sample = sample_light(scene, table, table.sampled, position, pick.a, place)
    way = wp.normalize(wp.vec3(2.0 * place.x - 1.0, 0.3, 2.0 * place.y - 1.0))
    found = light_at_hit(scene, table, table.sampled, position, way, closest_hit(scene, position, way, 1.0e6))
    out[index] = wp.vec3(sample.irradiance[0] * wp.max(sample.direction[1], 0.0), found.radiance[0], found.density)


def under(dome: Material, *lights: Light, outwards: bool = False) -> DeviceScene:
    ball = icosphere(3, 5.0)
    shell = MeshPart(np.asarray(ball.vertices), np.asarray(ball.faces[:, :: 1 if outwards else -1]), material=1)
    return DeviceScene(scene_of([GROUND, shell], [Material(), dome], lights), "cpu")


def behind(device_scene: DeviceScene) -> Doubles:
    ways = np.random.default_rng(0).normal(size=(50, 3))
    ways[:, 1] = np.abs(ways[:, 1])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return results(behind_kernel, len(ways), [device_scene.data, column(ways, wp.vec3)], wp.vec4)


@pytest.mark.parametrize("sides", [None, False, True])
def test_a_sky_of_triangles_is_seen_and_met_by_nothing(sides: bool | None) -> None:
    dome = Material(base_color=(0.4, 0.6, 1.0, 1.0), unlit=True, double_sided=sides)
    assert behind(under(dome)) == pytest.approx(np.tile([0.4, 0.6, 1.0, 0.0], (50, 1)))


def test_the_back_of_one_that_faces_outwards_is_not_seen() -> None:
    dome = Material(base_color=(0.4, 0.6, 1.0, 1.0), unlit=True, double_sided=False)
    seen = behind(under(dome, outwards=True))
    assert seen[:, 0] == pytest.approx(seen[:, 2])  # the soft sky


def test_an_emissive_one_goes_on_to_give_its_light() -> None:
    device_scene = under(Material(emission=(2.0, 2.0, 2.0)), SUN)
    table = build_light_table(device_scene)
    sampled, met, density = results(irradiance_kernel, COUNT, [device_scene.data, table], wp.vec3).T
    assert sampled.mean() == pytest.approx(2.0 * np.pi, rel=0.02)
    assert met == pytest.approx(np.full(COUNT, 2.0))
    assert (density > 0.0).all()
    assert behind(device_scene) == pytest.approx(np.tile([2.0, 2.0, 2.0, 0.0], (50, 1)))


def test_the_sun_is_as_wide_as_what_it_can_light() -> None:
    plain = DeviceScene(scene_of([GROUND], [Material()], [SUN]), "cpu")
    assert build_light_table(under(Material(unlit=True), SUN)).radius == pytest.approx(build_light_table(plain).radius)
