from typing import Any

import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.assemble import assemble
from gpu.scene.file_frame import FileFrame
from gpu.scene.import_options import ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Light, LightKind, Material, Scene, Sky, Texture, TextureSlot

QUAD = np.array([[0.0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
GREY = Material()
LAMP = Material(emission=(1.0, 1.0, 1.0))


def scene_of(
    *parts: MeshPart, materials: tuple[Material, ...] = (GREY,), limits: SceneLimits = DEFAULT_LIMITS, **more: Any
) -> Scene:
    return assemble("scene", SceneParts(parts, materials, up="y", metres_per_unit=1.0, **more), limits)


def test_the_largest_extent_becomes_one_around_the_origin() -> None:
    scene = scene_of(MeshPart(QUAD + 10, TWO))
    assert np.allclose(scene.vertices.min(axis=0), (-0.5, -0.25, 0))
    assert np.allclose(scene.vertices.max(axis=0), (0.5, 0.25, 0))
    assert scene.placement.scale == 0.25
    assert scene.placement.centre == (12.0, 11.0, 10.0)


def test_small_things_far_away_keep_their_shape() -> None:
    """In float32, a metre at a distance of 10⁷ metres has steps of one metre; the difference is taken in float64."""
    scene = scene_of(MeshPart(QUAD + 1e7, TWO))
    assert np.allclose(scene.vertices[:, :2], [[-0.5, -0.25], [0.5, -0.25], [0.5, 0.25], [-0.5, -0.25], [0.5, 0.25],
                                               [-0.5, 0.25]])  # fmt: skip


def test_vertices_that_no_triangle_uses_do_not_count() -> None:
    positions = np.vstack([QUAD, [[1e6, 0, 0]]])
    scene = scene_of(MeshPart(positions, TWO, np.tile([0.0, 0, 1], (5, 1))))
    assert len(scene.vertices) == 4
    assert scene.placement.scale == 0.25


@pytest.mark.parametrize(
    "bad",
    [[0, 0, 1], [1, 4, 5], [2, 6, 7]],
    ids=["a repeated index", "a line", "too small for float32"],
)
def test_degenerate_triangles_are_dropped_and_counted(bad: list[int]) -> None:
    positions = np.vstack([QUAD, [[4.0, 1.5, 0], [4.0, 0.1, 0], [4, 2, 1e-9], [4, 2 + 1e-9, 0]]])
    scene = scene_of(MeshPart(positions, np.array([*TWO, bad])))
    assert len(scene.triangles) == 2
    assert scene.report.dropped_triangles == 1


def test_thin_triangles_are_kept() -> None:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1e-4, 0]])
    assert len(scene_of(MeshPart(positions, np.array([[0, 1, 2]]))).triangles) == 1


def test_parts_are_merged() -> None:
    color = np.tile([1.0, 0, 0, 1], (4, 1))
    first = MeshPart(QUAD, TWO, np.tile([0.0, 0, 3], (4, 1)), (QUAD[:, :2],), material=1)
    second = MeshPart(QUAD + 8, TWO, np.tile([0.0, 2, 0], (4, 1)), (QUAD[:, :2], QUAD[:, 1:]), color)
    slot = TextureSlot(0, uv_set=1)
    texture = Texture("t", np.zeros((1, 1, 4), np.uint8), srgb=True)
    scene = scene_of(first, second, materials=(Material(base_color_slot=slot), LAMP), textures=[texture])
    assert scene.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    assert scene.triangle_material.tolist() == [1, 1, 0, 0]
    assert np.array_equal(scene.normals, [[0, 0, 1]] * 4 + [[0, 1, 0]] * 4)
    assert np.array_equal(scene.uvs[0], np.tile(QUAD[:, :2], (2, 1)))
    assert np.array_equal(scene.uvs[1], np.vstack([np.zeros((4, 2)), QUAD[:, 1:]]))
    assert scene.colors is not None
    assert scene.colors[:, 1].tolist() == [1] * 4 + [0] * 4
    arrays = (scene.vertices, scene.normals, scene.uvs, scene.colors, scene.triangles, scene.triangle_material)
    assert [array.dtype for array in arrays] == [np.float32] * 4 + [np.int32] * 2


def test_uv_sets_that_no_material_uses_are_left_out_but_one_is_there() -> None:
    assert scene_of(MeshPart(QUAD, TWO, QUAD + 1, (QUAD[:, :2],) * 3)).uvs.shape == (1, 4, 2)
    assert not scene_of(MeshPart(QUAD, TWO, QUAD + 1)).uvs.any()


def test_without_normals_each_triangle_has_its_own() -> None:
    roof = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    scene = scene_of(MeshPart(roof, np.array([[0, 1, 2], [0, 3, 1]]), uvs=(roof[:, :2],)))
    assert len(scene.vertices) == 6
    assert np.allclose(scene.normals, [[0, 0, 1]] * 3 + [[0, 1, 0]] * 3)
    assert np.array_equal(scene.uvs[0], roof[[0, 1, 2, 0, 3, 1], :2])


def test_lights_move_and_shrink_with_the_scene() -> None:
    point = Light("p", LightKind.POINT, (16.0, 32.0, 0.0), (2.0, 1.0, 4.0))
    sun = Light("s", LightKind.DIRECTIONAL, (5.0, 5.0, 5.0), (9.0, 9.0, 9.0))
    scene = scene_of(MeshPart(QUAD, TWO), lights=[point, sun])
    assert scene.lights[0].position == (0.0, 0.0, 1.0)
    assert scene.lights[0].intensity == (1.0, 2.0, 0.0)  # irradiance I/d² stays the same
    assert scene.lights[1] == sun


def test_a_dark_scene_gets_a_sky_and_that_is_said() -> None:
    part = MeshPart(QUAD, TWO)
    scene = scene_of(part)
    assert scene.sky is not None
    assert any("sky" in note for note in scene.report.notes)
    unused = scene_of(part, materials=(GREY, LAMP))
    assert unused.sky is not None
    for lit in (
        scene_of(part, materials=(LAMP,)),
        scene_of(part, lights=[Light("p", LightKind.POINT, (1.0, 1.0, 1.0))]),
    ):
        assert lit.sky is None
        assert not any("sky" in note for note in lit.report.notes)
    assert scene_of(part, sky=Sky((2.0, 2.0, 2.0))).sky == Sky((2.0, 2.0, 2.0))


def test_a_scene_without_a_camera_gets_one_and_that_is_said() -> None:
    scene = scene_of(MeshPart(QUAD, TWO))
    assert len(scene.cameras) == 1
    assert any("camera" in note for note in scene.report.notes)
    kept = scene_of(MeshPart(QUAD, TWO), cameras=scene.cameras)
    assert not any("camera" in note for note in kept.report.notes)


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (MeshPart(QUAD, TWO[:0]), "no triangles"),
        (MeshPart(QUAD * 0, TWO), "none of its 2 triangles has an area"),
        (MeshPart(QUAD, TWO + 1, name="wall"), "wall.triangles[1]: index out of range"),
        (MeshPart(QUAD, TWO - 1), "mesh.triangles[0]"),
        (MeshPart(np.where(QUAD == 2, np.nan, QUAD), TWO), "mesh.positions[2]: is not finite"),
        (MeshPart(QUAD, TWO, uvs=(np.full((4, 2), np.inf),)), "mesh.uvs[0][0]: is not finite"),
        (MeshPart(QUAD, TWO, colors=np.full((4, 4), np.nan)), "mesh.colors[0]: is not finite"),
        (MeshPart(QUAD, TWO, QUAD[:3]), "3 values of an attribute, 4 vertices"),
        (MeshPart(QUAD, TWO, material=1), "mesh.material[0]: index out of range"),
    ],
)
def test_what_is_not_sound_is_refused(part: MeshPart, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_of(part)
    assert says in str(caught.value)
    assert str(caught.value).startswith("scene: ")


@pytest.mark.parametrize("limits", [SceneLimits(max_triangles=1), SceneLimits(max_vertices=5)])
def test_what_is_too_large_is_refused(limits: SceneLimits) -> None:
    with pytest.raises(SceneError, match=r"more than the .* allowed"):
        scene_of(MeshPart(QUAD, TWO), limits=limits)


@pytest.mark.parametrize("value", [1e101, -1e308])
def test_numbers_too_large_to_compute_with_are_named(value: float) -> None:
    with pytest.raises(SceneError, match=r"mesh.positions\[1\]: is beyond ±1e\+100"):
        scene_of(MeshPart(np.where(QUAD == [4, 0, 0], [value, 0, 0], QUAD)[[0, 1, 2, 3]], TWO))


@pytest.mark.parametrize("scale", [1e99, 1e-99, 1e-200, 5e-324])
def test_tiny_and_huge_scenes_are_scaled_or_have_no_area(scale: float) -> None:
    part = MeshPart(QUAD * scale, TWO)
    if scale >= 1e-99:
        assert np.allclose(scene_of(part).vertices.max(axis=0), (0.5, 0.25, 0))
    else:
        with pytest.raises(SceneError, match="has an area"):
            scene_of(part)


def test_what_a_file_says_of_up_and_unit_counts_unless_an_option_says_otherwise() -> None:
    found = SceneParts([MeshPart(QUAD, TWO)], [GREY], up="z", metres_per_unit=0.01)
    said = assemble("scene", found)
    assert said.frame == FileFrame("z", 0.01)
    assert np.allclose(1.0 / said.placement.scale, 0.04)
    assert np.allclose(np.ptp(said.vertices, axis=0), (1.0, 0.0, 0.5))
    assert np.allclose(said.normals, (0.0, 1.0, 0.0))
    chosen = assemble("scene", found, options=ImportOptions(up="y", unit="mm", origin=(2.0, 1.0, 0.0)))
    assert chosen.frame == FileFrame("y", 0.001, (2.0, 1.0, 0.0))
    assert np.allclose(chosen.placement.centre, 0.0)


def with_far_triangle(distance: float, material: int) -> Scene:
    far = MeshPart(QUAD[:3] / 10.0 + (distance, 0.0, 0.0), TWO[:1], material=material)
    return scene_of(MeshPart(QUAD, TWO), far, materials=(GREY, LAMP))


@pytest.mark.parametrize("distance", [1e2, 1e3, 1e4, 4.6e5, 1e6])
def test_what_is_small_and_far_away_sets_neither_bounds_nor_the_default_view(distance: float) -> None:
    alone, scene = scene_of(MeshPart(QUAD, TWO)), with_far_triangle(distance, 0)
    assert scene.bounds == alone.bounds == ((0.0, 0.0, 0.0), (4.0, 2.0, 0.0))
    assert np.allclose(scene.cameras[0].to_world, alone.cameras[0].to_world, rtol=1e-3, atol=0.01)
    assert len(scene.triangles) == 2 + (distance == 1e2)


def test_what_is_too_far_away_is_left_out_with_a_word() -> None:
    scene = with_far_triangle(4.6e5, 0)
    assert scene.placement.scale == 0.25
    assert scene.report.notes[0].endswith("460 km away: 1")
    assert scene.report.dropped_triangles == 0


def test_a_lamp_far_away_is_kept() -> None:
    scene = with_far_triangle(1e5, 1)
    assert len(scene.triangles) == 3
    assert scene.bounds[1] == (4.0, 2.0, 0.0)
    assert "leave out what is far away" in scene.report.notes[0]


def test_what_is_left_of_nothing_but_far_corners_is_said() -> None:
    """A triangle of the bulk may be a point in single precision beside one that reaches far."""
    near = MeshPart(QUAD * 1e-12, TWO)
    far = MeshPart(np.array([[0.0, 0, 0], [1e30, 0, 0], [1e30, 1e-30, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(SceneError, match="triangles has an area"):
        scene_of(near, far, materials=(LAMP,))


def test_texture_coordinates_stay_numbers() -> None:
    scene = scene_of(MeshPart(QUAD, TWO, uvs=(np.full((4, 2), 1e300),)))
    assert np.isfinite(scene.uvs).all()
