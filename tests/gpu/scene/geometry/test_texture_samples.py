"""Textures read on the host as on a device."""

import numpy as np
import pytest
import warp as wp
from scenes import column, quad, resident_of, results

from gpu.device_scene.data import SceneData
from gpu.device_scene.textures import sample_texture as device_sample
from gpu.scene.geometry.texture_samples import sample_texture
from gpu.scene.types import Material, Texture, TextureSlot, Wrap


@wp.kernel
def sample_kernel(first: int, scene: SceneData, material: int, uvs: wp.array[wp.vec2],
                  out: wp.array[wp.vec4]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = device_sample(scene, scene.slots[scene.materials[material].first_slot], uvs[index])


@pytest.mark.parametrize("nearest", [False, True])
@pytest.mark.parametrize("wraps", [(Wrap.REPEAT, Wrap.CLAMP), (Wrap.MIRROR, Wrap.REPEAT), (Wrap.CLAMP, Wrap.MIRROR)])
def test_what_a_device_reads_is_read(nearest: bool, wraps: tuple[Wrap, Wrap]) -> None:
    rng = np.random.default_rng(2)
    texture = Texture("noise", rng.integers(0, 256, (5, 7, 4), np.uint8), True, *wraps, nearest=nearest)
    slot = TextureSlot(0, 0, (0.5, -1.5, 0.25, 2.0, 0.75, -0.5))
    device_scene = resident_of([quad([0, 0, 0], [1, 0, 0], [0, 1, 0])], [Material(base_color_slot=slot)],
                               textures=[texture])  # fmt: skip
    uvs = rng.uniform(-3.0, 3.0, (300, 2)).astype(np.float32)
    expected = results(sample_kernel, len(uvs), [device_scene.data, 0, column(uvs, wp.vec2)], wp.vec4)
    same = np.isclose(sample_texture(texture, slot, uvs.astype(float)), expected, atol=1e-4).all(axis=1)
    assert same.mean() > 0.99  # rounding may take another texel
