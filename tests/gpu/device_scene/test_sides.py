"""What both sides of a surface do, and what alpha leaves of it."""

import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of, results

from gpu.device_scene.data import HALF, WHOLE, SceneData
from gpu.device_scene.rays import closest_hit, seen_hit
from gpu.device_scene.sides import emits_from_back, emitting_normal, is_solid, solid_share, triangle_normal
from gpu.device_scene.surface import emission_at, emitted_at
from gpu.device_scene.upload import DeviceScene
from gpu.sampling.sobol import hashed
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import AlphaMode, Material, Texture, TextureSlot

CUT = np.full((8, 8, 4), 255, np.uint8)
CUT[:, :4, 3] = 60
PLACES = np.array([[0.8, 0.1], [0.1, 0.1], [0.1, 0.8]])  # of triangle 0, the first in the half that is cut away
SQUARE = quad([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


@wp.kernel
def solid_kernel(first: int, scene: SceneData, places: wp.array[wp.vec2], out: wp.array[wp.vec2]) -> None:
    """Whether there is something at places of triangle 0, and what it emits there to rays that meet it."""
    index = first + wp.tid()
    u = places[index][0]
    v = places[index][1]
    out[index] = wp.vec2(float(int(is_solid(scene, 0, u, v))), emission_at(scene, 0, u, v)[0])


@wp.kernel
def side_kernel(first: int, scene: SceneData, out: wp.array[wp.vec4]) -> None:
    """Of triangle 0: z of the normal that emits to the front and to the back and of its own; whether the back emits."""
    index = first + wp.tid()
    up = wp.vec3(0.0, 0.6, 0.8)
    out[index] = wp.vec4(
        emitting_normal(scene, 0, up)[2],
        emitting_normal(scene, 0, -up)[2],
        triangle_normal(scene, 0)[2],
        float(int(emits_from_back(scene, 0))),
    )


@wp.kernel
def met_kernel(first: int, scene: SceneData, heights: wp.array[float], out: wp.array[wp.vec2]) -> None:
    """The first triangle towards the middle that a camera sees from each height, and that light meets."""
    index = first + wp.tid()
    origin = wp.vec3(0.1, -0.2, heights[index])
    direction = wp.vec3(0.0, 0.0, -wp.sign(heights[index]))
    out[index] = wp.vec2(
        float(seen_hit(scene, origin, direction).face), float(closest_hit(scene, origin, direction, 10.0).face)
    )


def masked(mode: AlphaMode, **rest: object) -> DeviceScene:
    material = Material(emission=(3.0, 3.0, 3.0), alpha_mode=mode, base_color_slot=TextureSlot(0), **rest)
    return resident_of([SQUARE], [material], textures=[Texture("half", CUT, srgb=True, nearest=True)])


def test_what_alpha_cuts_away_is_not_there_and_emits_nothing() -> None:
    device_scene = masked(AlphaMode.MASK)
    found = results(solid_kernel, 3, [device_scene.data, column(PLACES, wp.vec2)], wp.vec2)
    assert found.tolist() == [[0.0, 0.0], [1.0, 3.0], [1.0, 3.0]]
    ignored = device_scene.view(lambertian=True)
    assert (results(solid_kernel, 3, [ignored, column(PLACES, wp.vec2)], wp.vec2) == [1.0, 3.0]).all()


def test_alpha_of_opaque_surfaces_means_nothing() -> None:
    found = results(solid_kernel, 3, [masked(AlphaMode.OPAQUE).data, column(PLACES, wp.vec2)], wp.vec2)
    assert (found == [1.0, 3.0]).all()


def test_alpha_of_vertices_cuts_away_too() -> None:
    colors = np.ones((4, 4))
    colors[:, 3] = 0.3
    part = MeshPart(SQUARE.positions, SQUARE.triangles, uvs=SQUARE.uvs, colors=colors)
    device_scene = resident_of([part], [Material(emission=(3.0, 3.0, 3.0), alpha_mode=AlphaMode.MASK)])
    assert not results(solid_kernel, 3, [device_scene.data, column(PLACES, wp.vec2)], wp.vec2).any()


@pytest.mark.parametrize(("sides", "back"), [(None, False), (False, False), (True, True)])
def test_two_sided_surfaces_emit_from_the_back_too(sides: bool | None, back: bool) -> None:
    device_scene = resident_of([SQUARE], [Material(emission=(1.0, 1.0, 1.0), double_sided=sides)])
    found = results(side_kernel, 1, [device_scene.data], wp.vec4)[0]
    assert found.tolist() == [1.0, -1.0 if back else 1.0, 1.0, float(back)]


@pytest.mark.parametrize(("sides", "seen"), [(None, True), (False, False), (True, True)])
@pytest.mark.parametrize("mode", list(AlphaMode))
def test_cameras_alone_look_through_backs_of_one_sided_surfaces(
    sides: bool | None, seen: bool, mode: AlphaMode
) -> None:
    device_scene = resident_of([SQUARE], [Material(double_sided=sides, alpha_mode=mode)])
    found = results(met_kernel, 2, [device_scene.data, column([0.5, -0.5], float)], wp.vec2)
    assert (found[:, 1] >= 0).all()
    assert found[0, 0] >= 0
    assert (found[1, 0] >= 0) == seen
    everything = results(met_kernel, 2, [device_scene.view(lambertian=True), column([0.5, -0.5], float)], wp.vec2)
    assert (everything >= 0).all()


@pytest.mark.parametrize("sides", [None, False, True])
def test_two_skins_in_one_place_each_show_to_their_side(sides: bool | None) -> None:
    back = quad([-0.5, -0.5, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 1)
    materials = [Material(double_sided=sides), Material(base_color=(0.2, 0.2, 0.2, 1.0), double_sided=sides)]
    device_scene = resident_of([SQUARE, back], [*materials, grey(0.5)])
    found = results(met_kernel, 2, [device_scene.data, column([0.5, -0.5], float)], wp.vec2)
    assert (found // 2).tolist() == [[0.0, 0.0], [1.0, 1.0]]


@wp.kernel
def share_kernel(first: int, scene: SceneData, out: wp.array[wp.vec4]) -> None:
    """Of a place of triangle 0: the share that is there, whether rays meet it that take one half for all, and those
    that take any of it for all; what it emits where it is chosen.
    """
    share = solid_share(scene, 0, 0.1, 0.1)
    emitted = emitted_at(scene, 0, 0.1, 0.1)[0]
    scene.coverage = HALF
    by_half = float(int(is_solid(scene, 0, 0.1, 0.1)))
    scene.coverage = WHOLE
    out[first + wp.tid()] = wp.vec4(share, by_half, float(int(is_solid(scene, 0, 0.1, 0.1))), emitted)


@pytest.mark.parametrize(
    ("mode", "alpha", "expected"),
    [
        (AlphaMode.BLEND, 0.3, [0.3, 0.0, 1.0, 0.9]),
        (AlphaMode.BLEND, 0.7, [0.7, 1.0, 1.0, 2.1]),
        (AlphaMode.BLEND, 0.0, [0.0, 0.0, 0.0, 0.0]),
        (AlphaMode.MASK, 0.3, [0.0, 0.0, 0.0, 0.0]),
        (AlphaMode.MASK, 0.7, [1.0, 1.0, 1.0, 3.0]),
        (AlphaMode.OPAQUE, 0.3, [1.0, 1.0, 1.0, 3.0]),
    ],
)
def test_of_blended_surfaces_a_share_of_alpha_is_there_and_emits(
    mode: AlphaMode, alpha: float, expected: list[float]
) -> None:
    material = Material(base_color=(1.0, 1.0, 1.0, alpha), emission=(3.0, 3.0, 3.0), alpha_mode=mode)
    found = results(share_kernel, 1, [resident_of([SQUARE], [material]).data], wp.vec4)[0]
    assert found == pytest.approx(expected, abs=1e-6)
    lambertian = resident_of([SQUARE], [material]).view(lambertian=True)
    assert results(share_kernel, 1, [lambertian], wp.vec4)[0] == pytest.approx([1.0, 1.0, 1.0, 3.0])


@wp.kernel
def covered_kernel(first: int, scene: SceneData, out: wp.array[wp.vec3]) -> None:
    """Whether place `first` of triangle 0 is there for a ray of its own, asked twice, and for one that ray 0 is."""
    index = first + wp.tid()
    place = 0.8 * (float(index) + 0.5) / 16384.0
    scene.coverage = hashed(wp.uint32(index)) | wp.uint32(1)
    one = float(int(is_solid(scene, 0, 0.1, 0.1)))
    again = float(int(is_solid(scene, 0, 0.1, 0.1)))
    scene.coverage = wp.uint32(1)
    out[index] = wp.vec3(one, again, float(int(is_solid(scene, 0, place, 0.1))))


@pytest.mark.parametrize(("mode", "share"), [(AlphaMode.BLEND, 0.3), (AlphaMode.MASK, 0.0)])
def test_blended_surfaces_are_there_at_random_by_alpha(mode: AlphaMode, share: float) -> None:
    material = Material(base_color=(1.0, 1.0, 1.0, 0.3), alpha_mode=mode)
    found = results(covered_kernel, 16384, [resident_of([SQUARE], [material]).data], wp.vec3)
    assert np.array_equal(found[:, 0], found[:, 1])
    assert np.allclose(found.mean(axis=0), share, atol=0.015)
    if share:
        assert abs(np.corrcoef(found[:-1, 2], found[1:, 2])[0, 1]) < 0.03
