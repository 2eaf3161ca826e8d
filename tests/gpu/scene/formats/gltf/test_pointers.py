import numpy as np
import pytest
from gltf_file import GltfFile

PLACE = "animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer"


@pytest.mark.parametrize(
    ("pointer", "words"),
    [
        (
            "materials/0/alphaCutoff",
            "must lead to a property of a node, a material or a light, not 'materials/0/alphaCut",
        ),
        ("/materials/00/alphaCutoff", "must lead to a property of a node, a material or a light"),
        ("/cameras/0/perspective/yfov", "must lead to a property of a node, a material or a light"),
        ("/materials/7/alphaCutoff", "'/materials/7/alphaCutoff' leads to what does not exist"),
        ("/extensions/KHR_lights_punctual/lights/0/color", "leads to what does not exist"),
        ("/materials/0/pbrMetallicRoughness/baseColor", "baseColor': this does not move here"),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
            "texture transforms do not move here",
        ),
        (3, "must be a string"),
        (None, "'pointer' is missing"),
    ],
)
def test_a_pointer_that_leads_nowhere_is_said_by_its_place(gltf: GltfFile, pointer: object, words: str) -> None:
    gltf.add("materials")
    gltf.mesh_node(gltf.primitive(material=0))
    said = {} if pointer is None else {"pointer": pointer}
    target = {"path": "pointer", "extensions": {"KHR_animation_pointer": said}}
    sampler = {"input": gltf.accessor(np.float32([0, 1])), "output": gltf.accessor(np.float32([0, 1]))}
    gltf.add("animations", samplers=[sampler], channels=[{"sampler": 0, "target": target}])
    scene = gltf.load()
    assert scene.motion is None
    channel = scene.report.ignored[0]
    assert channel.startswith(PLACE if pointer is not None else PLACE.removesuffix(".pointer"))
    assert words in channel
    assert channel.endswith("; the channel was left out")


def test_what_shines_at_some_time_is_a_light_with_its_texture(gltf: GltfFile) -> None:
    gltf.add("materials", name="dark")
    gltf.add("materials", name="sign")
    gltf.mesh_node(gltf.primitive(material=0), gltf.primitive(material=1))
    target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/1/emissiveFactor"}}}
    rows = gltf.accessor(np.float32([[0, 0, 0], [1, 0, 0]]))
    sampler = {"input": gltf.accessor(np.float32([0, 1])), "output": rows}
    gltf.add("animations", samplers=[sampler], channels=[{"sampler": 0, "target": target}])
    assert [material.emits for material in gltf.load().materials] == [False, True]
