from dataclasses import replace
from math import inf, nan

import numpy as np

from gpu.scene.computable import computable
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Camera, Light, LightKind, Material, Sky, TextureSlot


def test_factors_outside_their_range_are_mended_and_said() -> None:
    lamp = Material("lamp", emission=(1e300, 2.0, 0.0), ior=1e39)
    paint = Material("paint", base_color=(2.0, -1.0, nan, 0.5), roughness=nan, metallic=inf)
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1e60, nan))
    found = computable(SceneParts((), [Material(), lamp, paint], lights=[sun], sky=Sky((inf, 1.0, 0.0)), notes=["a"]))
    assert found.materials == [
        Material(),
        Material("lamp", emission=(1e30, 2.0, 0.0), ior=1e6),
        Material("paint", base_color=(1.0, 0.0, 1.0, 0.5), roughness=1.0, metallic=1.0),
    ]
    assert found.lights[0].intensity == (1.0, 1e30, 0.0)
    assert found.sky == Sky((1e30, 1.0, 0.0))
    assert found.notes == (
        "a",
        "lamp.emission: must be between 0 and 1e+30, not 1e+300; 1e+30 was taken "
        "(likewise sun.intensity, sky.radiance)",
        "lamp.ior: must be between 0 and 1e+06, not 1e+39; 1e+06 was taken",
        "paint.base_color: must be between 0 and 1, not 2; 1 was taken (likewise paint.metallic, paint.roughness)",
    )


def test_textures_lie_where_numbers_reach() -> None:
    slot = TextureSlot(0, transform=(1e300, 0.0, nan, 0.0, 1.0, -1e7))
    found = computable(SceneParts((), [Material("m", normal_slot=slot, normal_scale=-1e300)]))
    (material,) = found.materials
    assert material.normal_slot == TextureSlot(0, transform=(1e6, 0.0, 0.0, 0.0, 1.0, -1e6))
    assert material.normal_scale == -1e6
    assert found.notes == (
        "m.normal_scale: must be between -1e+06 and 1e+06, not -1e+300; -1e+06 was taken "
        "(likewise m.normal_slot.transform)",
    )


def test_colours_of_vertices_are_shares() -> None:
    colors = np.array([[7.0, -1.0, 0.5, 1.0], [1.0, inf, 0.0, 1.0]])
    plain = MeshPart(np.zeros((2, 3)), np.zeros((0, 3), np.int32), colors=np.ones((2, 4)))
    found = computable(SceneParts([replace(plain, colors=colors, name="wall"), plain], ()))
    assert found.meshes[0].colors is not None
    assert found.meshes[0].colors.tolist() == [[1.0, 0.0, 0.5, 1.0], [1.0, 1.0, 0.0, 1.0]]
    assert found.meshes[1] is plain
    assert found.notes == ("wall: has colours outside 0 to 1, which were clamped",)


def test_factors_within_their_range_stay_as_they_are() -> None:
    found = SceneParts(
        (), [Material(emission=(1e30, 0.0, 0.0))], lights=[Light("bulb", LightKind.POINT, (1e30, 1.0, 1.0))]
    )
    assert computable(found) is found


def test_cameras_that_can_see_nothing_are_left_out_and_said() -> None:
    place, nowhere = np.eye(4), np.full((4, 4), nan)
    wrong = [(place, 0.0), (place, inf), (place, 1e31), (nowhere, 1.0)]
    cameras = [Camera("front", place, 1.0), *(Camera(f"c{at}", *it) for at, it in enumerate(wrong))]
    found = computable(SceneParts((), (), cameras=[*cameras, Camera("far", place, 1.0, near=1e31)]))
    assert [camera.name for camera in found.cameras] == ["front"]
    assert found.notes == ("c0: a camera that cannot see anything was left out (likewise c1, c2, c3, far)",)
