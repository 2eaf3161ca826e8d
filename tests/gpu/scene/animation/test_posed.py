from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from gltf_file import TRIANGLE, GltfFile, corners
from gltf_motion import moving

from gpu.errors import UserError
from gpu.scene.animation.posed import posed
from gpu.scene.types import Scene


def at(scene: Scene, time: float) -> Scene:
    assert scene.motion is not None
    return posed(scene, scene.motion, scene.motion.animations[0], time)


def same(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and one.tobytes() == other.tobytes()
    return bool(one == other)


@pytest.mark.parametrize("time", [0.0, 1.0])
def test_a_posed_scene_has_the_bits_of_a_file_posed_so(tmp_path: Path, time: float) -> None:
    still, found = moving(tmp_path, time).load(), at(moving(tmp_path).load(), time)
    names = [field.name for field in fields(Scene) if field.name not in ("motion", "cameras")]
    assert [name for name in names if not same(getattr(still, name), getattr(found, name))] == []
    assert found.cameras[0].view_key == still.cameras[0].view_key


def test_what_does_not_move_stays_the_same_array_of_triangles(tmp_path: Path) -> None:
    scene = moving(tmp_path).load()
    found = at(scene, 0.5)
    assert found.triangles is scene.triangles
    assert found.triangle_material is scene.triangle_material
    assert found.materials is scene.materials
    assert (found.placement, found.bounds) == (scene.placement, scene.bounds)


def test_triangles_without_area_are_gone_as_long_as_they_have_none(tmp_path: Path) -> None:
    scene = moving(tmp_path).load()
    assert len(at(scene, 2.0).triangles) == len(scene.triangles) - 1
    assert len(at(scene, 1.9).triangles) == len(scene.triangles)


def scaled(gltf: GltfFile, scale: list[float], **more: object) -> Scene:
    """Two triangles, of which one, `more` said of its primitive, has a scale from 1 to `scale` in a second."""
    gltf.mesh_node()
    node = gltf.mesh_node(gltf.primitive(TRIANGLE + 2, **more))
    sampler = {"input": gltf.accessor(np.float32([0, 1])), "output": gltf.accessor(np.float32([[1, 1, 1], scale]))}
    channels = [{"sampler": 0, "target": {"node": node, "path": "scale"}}]
    gltf.json["animations"] = [{"samplers": [sampler], "channels": channels}]
    return gltf.load()


@pytest.mark.parametrize("normals", [{}, {"NORMAL": np.tile(np.float32([[0, 0, 1]]), (3, 1))}])
def test_what_becomes_mirrored_has_its_front_outside(tmp_path: Path, normals: dict[str, np.ndarray]) -> None:
    found = at(scaled(GltfFile(tmp_path), [-1, 1, 1], **normals), 1.0)
    a, b, c = corners(found)[1]
    assert sorted(corners(found)[1].tolist()) == sorted(((TRIANGLE + 2) * [-1, 1, 1]).tolist())
    assert np.cross(b - a, c - a)[2] > 0.0
    assert np.allclose(found.normals[found.triangles[1]], [0, 0, 1])


@pytest.mark.parametrize("scale", [1e8, 3e38])
def test_what_goes_too_far_away_is_refused(tmp_path: Path, scale: float) -> None:
    with pytest.raises(UserError, match=r"^time: at 1 s the animation takes things farther than can be shown$"):
        at(scaled(GltfFile(tmp_path), [scale, 1, 1]), 1.0)


@pytest.mark.parametrize("hung", [{"camera": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}])
def test_lights_and_cameras_that_go_too_far_away_are_refused(tmp_path: Path, hung: dict[str, object]) -> None:
    gltf = GltfFile(tmp_path)
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0})
    gltf.mesh_node()
    gltf.add("nodes", **hung)
    keys = np.float32([[0, 0, 0], [3e38, 0, 0]])
    sampler = {"input": gltf.accessor(np.float32([0, 1])), "output": gltf.accessor(keys)}
    channels = [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]
    gltf.json["animations"] = [{"samplers": [sampler], "channels": channels}]
    with pytest.raises(UserError, match=r"^time: at 1 s the animation takes things farther than can be shown$"):
        at(gltf.load(), 1.0)


def test_a_scene_of_which_nothing_is_left_is_refused(tmp_path: Path) -> None:
    scene = scaled(GltfFile(tmp_path), [0, 0, 0])
    alone = replace(scene, triangles=scene.triangles[1:], triangle_material=scene.triangle_material[1:])
    with pytest.raises(UserError, match=r"^time: at 1 s nothing of the scene is visible and has an area"):
        at(alone, 1.0)
