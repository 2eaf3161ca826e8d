from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from emitters import POINT
from scenes import box, grey, quad, resident_of

from gpu.core.radix_sort import iota_kernel
from gpu.device_scene.binary_tree import read_nodes_kernel
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_collapse import collapse_kernel
from gpu.device_scene.bvh_reinsertion import reinsert_kernel
from gpu.device_scene.features import scene_features
from gpu.device_scene.repeated import triangle_key_kernel
from gpu.device_scene.upload import DeviceScene, _load_side_by_side
from gpu.errors import DeviceError
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.types import AlphaMode, Material, Scene, Texture

MASKED = Material(alpha_mode=AlphaMode.MASK)
FLOOR, WALL = quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0], 0), quad([-0.5, 0, -0.5], [1, 0, 0], [0, 1, 0], 1)


def test_opaque_triangles_come_first_in_the_order_of_the_scene() -> None:
    device_scene = resident_of([FLOOR, WALL, FLOOR], [MASKED, grey(0.5)])
    assert device_scene.triangle_order.tolist() == [2, 3, 0, 1, 4, 5]
    data = device_scene.data
    assert (data.opaque_count, data.masked_count) == (2, 4)
    assert np.array_equal(data.triangles.numpy(), device_scene.scene.triangles[device_scene.triangle_order])
    assert data.triangle_material.numpy().tolist() == [1, 1, 0, 0, 0, 0]


def test_panes_have_a_tree_of_their_own_but_for_lambertian_views() -> None:
    body = Material(transmission=1.0, roughness=0.0, thickness=1.0)
    device_scene = resident_of([FLOOR, WALL], [body, grey(0.5)])
    data = device_scene.data
    assert (data.opaque_count, data.pane_count, data.masked_count) == (2, 2, 0)
    assert device_scene.triangle_order.tolist() == [2, 3, 0, 1]
    solid = device_scene.view(lambertian=True)
    assert (solid.opaque_count, solid.pane_count, solid.transmissive) == (4, 0, False)
    assert len(solid.opaque.faces) == 4
    assert device_scene.view(lambertian=False).opaque.faces.ptr == data.opaque.faces.ptr
    assert device_scene.view(lambertian=True).opaque.faces.ptr == solid.opaque.faces.ptr


@pytest.mark.parametrize(
    ("lambertian", "assumed", "alpha"), [(False, False, True), (True, False, False), (True, True, True)]
)
def test_a_lambertian_view_takes_masks_for_solid(lambertian: bool, assumed: bool, alpha: bool) -> None:
    device_scene = resident_of([FLOOR, WALL], [MASKED, grey(0.5)])
    view = device_scene.view(lambertian=lambertian, assume_alpha=assumed)
    assert (view.lambertian, view.ignore_alpha, view.alpha) == (lambertian, lambertian, alpha)
    assert not device_scene.data.lambertian
    assert not resident_of(box(), [grey(0.5)]).view(lambertian=False).alpha


def test_a_device_that_is_not_there_is_named() -> None:
    with pytest.raises(DeviceError, match="no device 'abacus' here"):
        DeviceScene(resident_of(box(), [grey(0.5)]).scene, "abacus")


def test_what_the_first_scene_takes_is_compiled_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[wp.Module] = []
    monkeypatch.setattr(wp, "force_load", lambda _, modules, **__: asked.extend(modules))
    _load_side_by_side.__wrapped__("cpu")
    for kernel in (collapse_kernel, reinsert_kernel, read_nodes_kernel, triangle_key_kernel, iota_kernel):
        assert kernel.module in asked


def test_edits_make_mirrors() -> None:
    plain = resident_of(box(), [Material(metallic=1.0)])
    polished = plain.edited(replace(plain.scene, materials=(Material(metallic=1.0, roughness=0.0),)))
    assert (plain.data.specular, polished.data.specular) == (False, True)
    assert not polished.view(lambertian=True).specular


def test_what_moved_takes_the_place_of_what_was_in_arrays_of_its_own() -> None:
    glass = Material(transmission=1.0, roughness=0.0, thickness=1.0)
    base = resident_of([FLOOR, replace(WALL, name="block")], [grey(0.5), glass])

    def moved(by: float) -> DeviceScene:
        return base.edited(edited(base.scene, SceneEdits(objects={"block": ObjectEdit(offset=(0.0, 0.0, by))})))

    assert not base.edited(base.scene).can_become(moved(0.1))  # whose arrays are the first scene's
    state, other = moved(0.1), moved(0.05)
    arrays, both = state.data, state.view(lambertian=True).opaque
    assert state.can_become(other)
    state.become(other)
    assert state.scene is other.scene
    assert state.data is arrays
    assert np.array_equal(arrays.vertices.numpy(), other.data.vertices.numpy())
    assert np.array_equal(arrays.panes.corners.numpy(), other.data.panes.corners.numpy())
    assert np.array_equal(both.corners.numpy(), other.view(lambertian=True).opaque.corners.numpy())
    state.become(base)
    assert np.array_equal(both.corners.numpy(), base.view(lambertian=True).opaque.corners.numpy())
    assert state.can_become(other)


def trees_of(scene: DeviceScene) -> dict[str, Bvh]:
    return {"opaque": scene.data.opaque, "panes": scene.data.panes, "both": scene.view(lambertian=True).opaque}


@pytest.mark.parametrize("dear", [False, True])
def test_what_nobody_needs_any_more_moves_in_its_arrays(dear: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """And trees that cost rays too much there are made anew."""
    glass = Material(transmission=1.0, roughness=0.0, thickness=1.0)
    small = quad([0.1, 0.2, -0.5], [0.2, 0, 0], [0, 0.2, 0], 0)
    sky = [quad([-9, 0, -9], [0, 0, 18], [18, 0, 0], 2)]
    quads = [FLOOR, replace(WALL, name="block"), replace(small, name="block"), *sky]
    base = resident_of(quads, [grey(0.5), glass, Material(backdrop=True)])

    def moved(by: float) -> Scene:
        return edited(base.scene, SceneEdits(objects={"block": ObjectEdit(offset=(0.0, 0.0, by))}))

    state = base.edited(moved(0.1))
    arrays, trees = state.data.vertices, trees_of(state)
    if dear:
        monkeypatch.setattr("gpu.device_scene.moved_tree.MOST_COST", 0.0)
    now = state.edited(moved(0.05), in_place=True)
    now.settle()
    assert now.data.vertices is arrays
    anew = DeviceScene(now.scene, "cpu")
    assert np.array_equal(arrays.numpy(), anew.data.vertices.numpy())
    assert now.solid_radius == anew.solid_radius
    assert now.data.backdrop.corners is state.data.backdrop.corners  # which nothing moves in
    for name, tree in trees_of(now).items():
        assert (tree.corners is trees[name].corners) is not dear
        same = trees_of(anew)[name]
        orders = [np.argsort(one.faces.numpy()) for one in (tree, same)]
        corners = [one.corners.numpy().reshape(-1, 12)[order] for one, order in zip((tree, same), orders, strict=True)]
        assert np.array_equal(*corners)


def test_what_a_scene_has_is_looked_for_again_where_an_edit_may_change_it() -> None:
    base = resident_of(box(), [grey(0.5)], lights=[POINT])
    known = base.features(lambertian=False)

    def state(**edits: dict[str, Any]) -> DeviceScene:
        return base.edited(edited(base.scene, SceneEdits(**edits)))

    moved = state(lights={"point": LightEdit(position=(0.0, 0.1, 0.0))})
    assert moved.features(lambertian=False) is known
    rough = state(materials={"default": MaterialEdit(metallic=1.0, roughness=0.0)})
    assert rough.features(lambertian=False) == scene_features(rough.scene, lambertian=False, constants=False) != known


def test_what_edits_leave_as_it_was_is_shared() -> None:
    pixels = Texture("grain", np.zeros((4, 4, 4), np.uint8), srgb=True)
    block = replace(WALL, name="block")
    base = resident_of([FLOOR, block], [grey(0.5), grey(0.2)], textures=[pixels])
    rough = base.edited(edited(base.scene, SceneEdits(materials={"default": MaterialEdit(roughness=0.3)})))
    assert rough.data.vertices is base.data.vertices
    assert rough.data.opaque.faces.ptr == base.data.opaque.faces.ptr
    roughness = [scene.data.materials.numpy()["roughness"].tolist() for scene in (base, rough)]
    assert roughness == [[1.0, 1.0], [pytest.approx(0.3), 1.0]]
    moved = base.edited(edited(base.scene, SceneEdits(objects={"block": ObjectEdit(offset=(0.0, 0.0, 0.1))})))
    assert moved.data.texels is base.data.texels
    ours = base.scene.vertex_object == base.scene.objects.index("block")
    found, before = (scene.data.vertices.numpy()[:, 2] for scene in (moved, base))
    assert np.allclose(found - before, np.where(ours, 0.1, 0.0), atol=1e-6)
    clear = base.edited(
        replace(base.scene, materials=(Material(transmission=1.0, roughness=0.0, thickness=1.0), grey(0.2)))
    )
    assert (clear.data.opaque_count, clear.data.pane_count) == (2, 2)


def test_what_moves_shares_triangles_and_takes_no_others() -> None:
    base = resident_of([FLOOR, replace(WALL, name="block"), replace(WALL, name="other")], [grey(0.5), grey(0.2)])

    def state(**objects: ObjectEdit) -> DeviceScene:
        return base.edited(edited(base.scene, SceneEdits(objects=objects)))

    moved, hidden = state(block=ObjectEdit(offset=(0.0, 0.0, 0.1))), state(block=ObjectEdit(visible=False))
    assert moved.data.triangles is base.data.triangles
    assert moved.data.vertices is not base.data.vertices
    assert not moved.can_become(hidden)  # whose triangles would take the place of the base's
    other = state(other=ObjectEdit(visible=False))
    assert hidden.can_become(other)
    hidden.become(other)
    assert np.array_equal(base.data.triangles.numpy(), base.scene.triangles)
    turned = base.edited(replace(base.scene, normals=-base.scene.normals))
    assert np.array_equal(turned.data.normals.numpy(), -base.data.normals.numpy())


def test_kernels_are_told_by_constants_what_a_scene_is_not_on_gpus_alone() -> None:
    own = resident_of([FLOOR, WALL], [grey(0.5), grey(0.5)])
    told = own.as_on_gpus()
    assert told.data is own.data
    changed = replace(own.scene, materials=(grey(0.2), grey(0.5)))
    for scene, constants in ((own, False), (told, True), (own.edited(changed), False), (told.edited(changed), True)):
        for choice in ({"lambertian": False}, {"lambertian": True}, {"lambertian": False, "assume_gloss": True}):
            assert scene.features(**choice) == scene_features(scene.scene, **choice, constants=constants)


def test_a_general_scene_is_the_same_in_the_same_arrays_and_so_are_edits_of_it() -> None:
    own = resident_of([FLOOR, WALL], [grey(0.5), grey(0.5)])
    general = own.generalised()
    assert general.data is own.data
    assert own.features(lambertian=False) != general.features(lambertian=False)
    assert own.features(lambertian=True) == general.features(lambertian=True)
    assert [it.view(lambertian=False).alpha for it in (own, general)] == [False, True]
    for material in (
        grey(0.2),
        Material(transmission=1.0, roughness=0.0, thickness=1.0),
    ):  # in the same triangles, and in others
        changed = replace(own.scene, materials=(material, own.scene.materials[1]))
        assert [it.edited(changed).general for it in (own, general)] == [False, True]
        assert not own.can_become(general.edited(changed))
    assert not general.generalised(general=False).general


def test_an_edit_may_leave_less_than_half_of_a_surface() -> None:
    veil = Material(base_color=(1.0, 1.0, 1.0, 0.9), alpha_mode=AlphaMode.BLEND)
    device_scene = resident_of(box(), [veil])
    fainter = replace(device_scene.scene, materials=[replace(veil, base_color=(1.0, 1.0, 1.0, 0.3))])
    edited = device_scene.edited(fainter)
    for state, sheer in ((device_scene, False), (edited, True)):
        assert state.view(lambertian=False).sheer == state.own_features(lambertian=False).sheer == sheer
