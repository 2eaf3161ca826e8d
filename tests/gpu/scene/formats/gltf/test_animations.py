from typing import Any

import numpy as np
import pytest
from gltf_file import UV, GltfFile

from gpu.scene.animation.motion import STILL, Interpolation, Motion, Property
from gpu.scene.animation.posed_look import with_look
from gpu.scene.formats.gltf import animations

SLIDE = np.float32([[0, 0, 0], [1, 0, 0]])


def sampler(gltf: GltfFile, values: Any = SLIDE, times: Any = (0, 2), **more: Any) -> dict[str, Any]:
    return {"input": gltf.accessor(np.float32(times)), "output": gltf.accessor(values), **more}


def animate(gltf: GltfFile, *channels: tuple[dict[str, Any], dict[str, Any]], **more: Any) -> None:
    """An animation of channels, each a sampler and a target."""
    listed = [{"sampler": number, "target": target} for number, (_, target) in enumerate(channels)]
    gltf.add("animations", samplers=[one for one, _ in channels], channels=listed, **more)


def motion_of(gltf: GltfFile) -> Motion:
    motion = gltf.load().motion
    assert motion is not None
    return motion


def test_channels_have_their_nodes_keys_and_kind(gltf: GltfFile) -> None:
    gltf.mesh_node(gltf.primitive(targets=[{}, {}]), rotation=[0, 1, 0, 0])
    spline = sampler(gltf, np.arange(24, dtype=np.float32).reshape(6, 4), interpolation="CUBICSPLINE")
    animate(gltf, (spline, {"node": 0, "path": "rotation"}), name="turn")
    weights = sampler(gltf, np.float32([0, 1, 2, 3, 4, 5]), (1, 2, 3.5), interpolation="STEP")
    animate(gltf, (weights, {"node": 0, "path": "weights"}), name="turn")
    motion = motion_of(gltf)
    assert [(one.id, one.seconds) for one in motion.animations] == [("turn", 2.0), ("turn (2)", 3.5)]
    (turn,), (bend,) = (one.channels for one in motion.animations)
    assert (turn.changes, turn.interpolation) == (Property.ROTATION, Interpolation.CUBICSPLINE)
    assert turn.values[1].tolist() == [[12, 13, 14, 15], [16, 17, 18, 19], [20, 21, 22, 23]]
    assert bend.times.tolist() == [1.0, 2.0, 3.5]
    assert bend.values[:, 0].tolist() == [[0, 1], [2, 3], [4, 5]]
    assert motion.rest[0].tolist() == [0, 0, 0, 0, 1, 0, 0, 1, 1, 1]


def test_only_what_moves_is_kept_of_meshes_lights_and_cameras(gltf: GltfFile) -> None:
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0})
    hung = {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    gltf.mesh_node(**hung)
    gltf.mesh_node(children=[2])
    gltf.mesh_node(**hung)
    animate(gltf, (sampler(gltf), {"node": 1, "path": "translation"}))
    motion = motion_of(gltf)
    assert [body.node for body in motion.bodies] == [1, 2]
    assert [body.first_vertex for body in motion.bodies] == [3, 6]
    assert motion.lights == motion.cameras == (STILL, 2)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"interpolation": "CUBIC"}, "must be one of STEP, LINEAR, CUBICSPLINE"),
        ({"interpolation": "CUBICSPLINE"}, "2 values for 2 keys"),
        ({"times": (2, 0)}, "its times must increase, from 0"),
        ({"times": (-1, 0)}, "its times must increase, from 0"),
        ({"times": (0, np.nan)}, "is not finite"),
        ({"values": SLIDE[:1]}, "1 values for 2 keys"),
        ({"values": SLIDE[:, :2]}, "has 2 components, expected 3"),
    ],
)
def test_broken_channels_are_left_out_and_said(gltf: GltfFile, change: dict[str, Any], words: str) -> None:
    gltf.mesh_node()
    animate(gltf, (sampler(gltf, **change), {"node": 0, "path": "translation"}))
    scene = gltf.load()
    assert scene.motion is None
    channel, animation = scene.report.ignored
    assert words in channel
    assert channel.endswith("the channel was left out")
    assert animation == "animations[0]: moves nothing that is shown and was left out"


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ({"node": 0, "path": "turn"}, "must be one of translation, rotation, scale, weights, not 'turn'"),
        ({"node": 7, "path": "scale"}, "7 does not exist"),
        ({"node": 1, "path": "scale"}, "moves a node that has a matrix"),
    ],
)
def test_channels_that_move_what_cannot_be_moved_are_said(gltf: GltfFile, target: dict[str, Any], words: str) -> None:
    gltf.mesh_node()
    gltf.mesh_node(matrix=np.eye(4).ravel().tolist())
    animate(gltf, (sampler(gltf), target), (sampler(gltf), {"node": 0, "path": "translation"}))
    scene = gltf.load()
    assert scene.motion is not None
    assert len(scene.motion.animations[0].channels) == 1
    (said,) = scene.report.ignored
    assert words in said


def test_nodes_that_are_not_shown_move_nothing(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.add("nodes")
    gltf.add("scenes", nodes=[0])
    animate(gltf, (sampler(gltf), {"node": 1, "path": "scale"}), (sampler(gltf), pointer("/nodes/1/translation")))
    scene = gltf.load()
    assert scene.motion is None
    assert "animations[0]: moves nothing that is shown and was left out" in scene.report.ignored


def pointer(text: str) -> dict[str, Any]:
    return {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": text}}}


def test_materials_that_tangents_turn_follow_their_own(gltf: GltfFile) -> None:
    gltf.add("materials", extensions={"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}})
    tangents = [np.float32(3 * [[np.cos(angle), np.sin(angle), 0.0, 1.0]]) for angle in (0.5, 1.0)]
    turned = (gltf.primitive(TEXCOORD_0=UV, TANGENT=one, material=0) for one in tangents)
    gltf.mesh_node(*turned, gltf.primitive())
    grow = sampler(gltf, np.float32([0.25, 0.75]))
    animate(gltf, (grow, pointer("/materials/0/pbrMetallicRoughness/roughnessFactor")))
    found = gltf.load()
    assert len(found.materials) == 3
    assert found.motion is not None
    later = with_look(found, found.motion, found.motion.animations[0], 2.0)
    steel = {number for number, material in enumerate(found.materials) if material.has_grain}
    assert len(steel) == 2
    assert [material.roughness == 0.75 for material in later.materials] == [number in steel for number in range(3)]


def test_pointers_are_of_nodes_materials_and_each_light_of_an_entry(gltf: GltfFile) -> None:
    lamp = {"extensions": {"KHR_lights_punctual": {"light": 1}}}
    gltf.json["extensions"] = {
        "KHR_lights_punctual": {"lights": [{"type": "point"}, {"type": "point", "color": [1, 0, 0]}]}
    }
    gltf.add("materials")
    gltf.add("materials", emissiveFactor=[0, 0.5, 0])
    gltf.mesh_node(gltf.primitive(material=1), **lamp)
    gltf.add("nodes", **lamp)
    grow = sampler(gltf, np.float32([1, 2]))
    lights = pointer("/extensions/KHR_lights_punctual/lights/1/intensity")
    strength = pointer("/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength")
    animate(gltf, (sampler(gltf), pointer("/nodes/0/scale")), (grow, strength), (grow, lights))
    found = motion_of(gltf).animations[0].channels
    assert [(one.changes, one.part, one.values[:, 0].tolist()) for one in found] == [
        (Property.SCALE, 0, SLIDE.tolist()),
        (Property.EMISSIVE_STRENGTH, 1, [[1.0], [2.0]]),
        (Property.INTENSITY, 0, [[1.0], [2.0]]),
        (Property.INTENSITY, 1, [[1.0], [2.0]]),
        (Property.EMISSIVE, 1, [[0.0, 0.5, 0.0]]),
        (Property.LIGHT_COLOR, 0, [[1.0, 0.0, 0.0]]),
        (Property.LIGHT_COLOR, 1, [[1.0, 0.0, 0.0]]),
    ]


def test_nodes_that_a_file_hides_stay_hidden_and_that_is_said(gltf: GltfFile) -> None:
    gltf.mesh_node()
    gltf.mesh_node(extensions={"KHR_node_visibility": {"visible": False}})
    shows = pointer("/nodes/1/extensions/KHR_node_visibility/visible")
    animate(gltf, (sampler(gltf, np.uint8([0, 1]), interpolation="STEP"), shows))
    scene = gltf.load()
    assert scene.motion is None
    assert any("target: shows a node that its file hides, which stays hidden" in said for said in scene.report.ignored)


def test_so_many_animations_are_offered(gltf: GltfFile, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(animations, "MOST_ANIMATIONS", 1)
    gltf.mesh_node()
    for _ in range(3):
        animate(gltf, (sampler(gltf), {"node": 0, "path": "translation"}))
    scene = gltf.load()
    assert scene.motion is not None
    assert len(scene.motion.animations) == 1
    assert scene.report.ignored == ("animations beyond the first 1 are not offered (2)",)
