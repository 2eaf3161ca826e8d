"""What frosted glass shows in single frames: in an evenly lit room, what it reflects and lets through of that."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import RARE, box, grey, quad, resident_of, results
from walls import CPU

from gpu.device_scene.data import SceneData
from gpu.direct.direct_light import direct_samples
from gpu.indirect.frosted_glass import beyond_face
from gpu.indirect.lobe_light import LobeRay, known_light
from gpu.scene.camera import look_at
from gpu.scene.types import AlphaMode, Doubles, Material
from gpu.vpl.light_sets import LightSetChoice, LightSets

SIZE = (24, 16)
CAMERA = look_at((0.1, 0.1, 0.3), (0.0, 0.0, -0.1), yfov_degrees=30.0)
COLOUR = np.array([1.0, 0.95, 0.9])


WALLS = grey(0.5, emission=1.0 / np.pi)


def blend(alpha: float, emission: float = 0.0) -> Material:
    """Black, and there by `alpha`."""
    return replace(grey(0.0, emission), base_color=(0.0, 0.0, 0.0, alpha), alpha_mode=AlphaMode.BLEND)


def shown(transmission: float = 1.0, *, direct: bool = True, walls: Material = WALLS,
          veil: Material | None = None, seed: int = 0) -> tuple[Doubles, Doubles]:  # fmt: skip
    """Of a coloured frosted sheet in a room whose walls emit 1/π and reflect half: what it shows besides what is matt
    of it, in parts of the light there is, and the albedo of that, (pixel, 3) each. veil: what is all around inside.
    """
    glass = Material(base_color=(*COLOUR, 1.0), transmission=transmission, roughness=0.4, specular=0.0)
    sheet = quad([-0.49, -0.49, 0.0], [0.98, 0, 0], [0, 0.98, 0], 1)
    parts = [*box(), sheet, *(box(2, 0.45) if veil else [])]
    device_scene = resident_of(parts, [walls, glass, veil or grey(0.5), *RARE]).generalised()
    lights = LightSets(device_scene)
    choice = LightSetChoice(vpls=5000, vpl_clusters=100, bounces=8, seed=seed, lambertian=False)
    cache = lights.radiosity(lights.made(choice, lambda what, fraction: None))
    view = FrameView(device_scene, SIZE, lambertian=False, traces_lobes=True)
    view.set_camera(CAMERA)
    view.find_shading_points()
    moment = wp.zeros(1, dtype=int, device=CPU)
    assert view.gloss
    known = known_light(lights.table, cache, direct=direct)
    view.gloss.trace(view.scene, view.camera, view.gbuffer, known, direct_samples(1, moment, seed))
    view.gloss.share(view.gbuffer, restores=False)
    view.radiance.zero_()
    view.gloss.add(view.gbuffer, view.radiance)
    return view.radiance.numpy() * np.pi / 2.0, view.gbuffer.albedo.numpy()


def test_frosted_glass_shows_what_is_before_and_behind_it() -> None:
    """About nine tenths goes through, tinted. Half of the light is of the emitters themselves."""
    light, matt = shown()
    assert np.allclose(matt, 0.0)
    assert light.mean(axis=0) == pytest.approx(0.08 + 0.9 * COLOUR, rel=0.06)
    reflected, _ = shown(direct=False)
    assert reflected.mean(axis=0) == pytest.approx((0.08 + 0.9 * COLOUR) / 2.0, rel=0.1)


def test_the_rest_of_what_is_partly_glass_is_matt() -> None:
    light, matt = shown(0.3)
    assert np.allclose(matt, 0.7 * COLOUR, atol=1e-3)
    assert light.mean(axis=0) == pytest.approx(0.3 * (0.08 + 0.9 * COLOUR), rel=0.06)


@pytest.mark.parametrize("alpha", [0.3, 0.6])
def test_what_is_there_in_part_shows_that_part(alpha: float) -> None:
    """Through frosted glass, where samples of lamps and rays find the same: lamps that are there in part, and veils."""
    light = np.mean([shown(walls=blend(alpha, 1.0 / np.pi), seed=seed)[0] for seed in range(4)], axis=0)
    assert light.mean(axis=0) == pytest.approx(alpha * (0.08 + 0.9 * COLOUR) / 2.0, rel=0.1)
    light, _ = shown(walls=grey(0.0, 1.0 / np.pi), veil=blend(alpha))
    assert light.mean(axis=0) == pytest.approx((1.0 - alpha) * (0.08 + 0.9 * COLOUR) / 2.0, rel=0.1)


@wp.kernel
def beyond_kernel(first: int, scene: SceneData, out: wp.array[wp.vec4]) -> None:
    """One thread a way: where a ray in a slab, from its front face straight to the other, goes and what that counts."""
    way = first + wp.tid()
    ray = LobeRay()
    ray.normal = wp.vec3(0.0, 0.0, -1.0)
    ray.direction = wp.vec3(0.0, 0.0, -1.0)
    ray.throughput = wp.vec3(1.0, 1.0, 1.0)
    beyond = beyond_face(scene, ray, way, 0.1, 0.3)
    out[way] = wp.vec4(beyond.direction[2], beyond.throughput[0], beyond.throughput[2], float(beyond.inside))


@pytest.mark.parametrize("roughness", [0.0, 0.2])
def test_a_body_shows_what_its_far_face_reflects_and_lets_through(roughness: float) -> None:
    """Each by its share, without a choice; past another surface there is one way only."""
    glass = Material(base_color=(*COLOUR, 1.0), transmission=1.0, roughness=roughness, thickness=1.0)
    for material, expected in (
        (glass, [[1.0, 0.04, 0.04, 1.0], [-1.0, 0.96 * 2.25, 0.96 * 2.25 * 0.9, 0.0]]),
        (grey(0.5), [[-1.0, 1.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0]]),
    ):
        far = quad([-0.4, -0.4, -0.1], [0, 0.8, 0], [0.8, 0, 0], 1)
        scene = resident_of([*box(), far], [grey(0.5), material]).view(lambertian=False)
        assert results(beyond_kernel, 2, [scene], wp.vec4) == pytest.approx(np.array(expected), abs=0.12)
