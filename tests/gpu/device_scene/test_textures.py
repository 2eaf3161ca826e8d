"""Textures against a plain NumPy twin."""

import numpy as np
import pytest
import warp as wp
from scenes import column, quad, resident_of, results

from gpu.core.device import launch
from gpu.device_scene.data import BASE_COLOR, SceneData
from gpu.device_scene.textures import sample_alpha, sample_texture, sample_use
from gpu.device_scene.textures import wrapped as device_wrapped
from gpu.scene.types import AlphaMode, Bytes, Doubles, Material, Texture, TextureSlot, Wrap

SAMPLERS = [
    (Wrap.REPEAT, Wrap.REPEAT, False, True),
    (Wrap.CLAMP, Wrap.MIRROR, False, True),
    (Wrap.MIRROR, Wrap.CLAMP, False, False),
    (Wrap.REPEAT, Wrap.MIRROR, True, False),
    (Wrap.CLAMP, Wrap.CLAMP, True, True),
]
TRANSFORM = (0.5, -1.5, 0.25, 2.0, 0.75, -0.5)


@wp.kernel
def sample_kernel(first: int, scene: SceneData, material: int, uvs: wp.array[wp.vec2],
                  out: wp.array[wp.vec4]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = sample_texture(scene, scene.slots[scene.materials[material].first_slot], uvs[index])


@wp.kernel
def slot_kernel(first: int, scene: SceneData, places: wp.array[wp.vec2], out: wp.array[wp.vec4]) -> None:
    """Colour of the base colour slot at places of triangle 0."""
    index = first + wp.tid()
    out[index] = sample_use(scene, BASE_COLOR, 0, places[index][0], places[index][1])


@wp.kernel
def alpha_kernel(first: int, scene: SceneData, places: wp.array[wp.vec2], out: wp.array[float]) -> None:
    index = first + wp.tid()
    out[index] = sample_alpha(scene, 0, places[index][0], places[index][1])


@wp.kernel
def wrapped_kernel(first: int, indices: wp.array[int], size: int, mode: int, out: wp.array[int]) -> None:
    index = first + wp.tid()
    out[index] = device_wrapped(indices[index], size, mode)


def wrapped(index: Doubles, size: int, wrap: Wrap) -> Doubles:
    if wrap is Wrap.CLAMP:
        return np.clip(index, 0, size - 1)
    if wrap is Wrap.REPEAT:
        return index % size
    return np.minimum(index % (2 * size), 2 * size - 1 - index % (2 * size))


def twin(texture: Texture, uv: Doubles) -> Doubles:
    """The texture at uv (sample, 2) as glTF defines it, linear RGBA (sample, 4)."""
    values = texture.pixels / 255.0
    if texture.srgb:
        colour = values[..., :3]
        linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
        values = np.concatenate([linear, values[..., 3:]], axis=2)
    height, width = values.shape[:2]

    def texel(x: Doubles, y: Doubles) -> Doubles:
        rows, columns = wrapped(y, height, texture.wrap_t), wrapped(x, width, texture.wrap_s)
        return np.asarray(values[rows.astype(int), columns.astype(int)])

    x, y = uv[:, 0] * width, uv[:, 1] * height
    if texture.nearest:
        return texel(np.floor(x), np.floor(y))
    x, y = x - 0.5, y - 0.5
    fx, fy = (x - np.floor(x))[:, None], (y - np.floor(y))[:, None]
    upper = texel(np.floor(x), np.floor(y)) * (1 - fx) + texel(np.floor(x) + 1, np.floor(y)) * fx
    lower = texel(np.floor(x), np.floor(y) + 1) * (1 - fx) + texel(np.floor(x) + 1, np.floor(y) + 1) * fx
    return np.asarray(upper * (1 - fy) + lower * fy)


@pytest.mark.parametrize("wrap", Wrap)
@pytest.mark.parametrize("size", [1, 2, 5])
def test_indices_are_wrapped_and_those_of_no_number_are_of_a_texel(size: int, wrap: Wrap, cpu: str) -> None:
    """Coordinates that are infinite in a file's transform would be read from elsewhere in memory."""
    near, extremes = np.arange(-1, 2 * size + 1), np.array([-(2**31), -(2**31) + 1, -9, 2 * size + 1, 2**31 - 1])
    indices = wp.array(np.concatenate([near, extremes]), dtype=int, device=cpu)
    out = wp.zeros(len(indices), dtype=int, device=cpu)
    launch(wrapped_kernel, len(indices), [indices, size, int(wrap), out], wp.get_device(cpu))
    found = out.numpy()
    assert np.array_equal(found[: len(near)], wrapped(near.astype(float), size, wrap))
    assert found.min() >= 0
    assert found.max() < size


def noise(height: int, width: int) -> Bytes:
    return np.random.default_rng(height * width).integers(0, 256, (height, width, 4), dtype=np.uint8)


@pytest.mark.parametrize("number", range(len(SAMPLERS)))
def test_wrap_modes_filters_and_decoding(number: int) -> None:
    textures = [Texture(str(k), noise(3 + k, 5), srgb, s, t, near) for k, (s, t, near, srgb) in enumerate(SAMPLERS)]
    materials = [Material(base_color_slot=TextureSlot(k, 0, TRANSFORM)) for k in range(len(textures))]
    parts = [quad([0, 0, 0], [1, 0, 0], [0, 1, 0], k) for k in range(len(textures))]
    device_scene = resident_of(parts, materials, textures=textures)
    # Multiples of 1/1024, which float32 transforms without rounding, off the texels' borders.
    uv = (np.random.default_rng(number).integers(-3000, 3000, (400, 2)) * 2 + 1) / 1024.0
    rows = np.array(TRANSFORM).reshape(2, 3)
    expected = twin(textures[number], uv @ rows[:, :2].T + rows[:, 2])
    got = results(sample_kernel, len(uv), [device_scene.data, number, column(uv, wp.vec2)], wp.vec4)
    assert np.allclose(got, expected, atol=2e-4)


def test_huge_coordinates_stay_in_the_image() -> None:
    parts = [quad([0, 0, 0], [1, 0, 0], [0, 1, 0], k) for k in range(3)]
    textures = [Texture(wrap.name, noise(4, 4), True, wrap, wrap) for wrap in Wrap]
    device_scene = resident_of(parts, [Material(base_color_slot=TextureSlot(k)) for k in range(3)], textures=textures)
    uv = np.array([[1e9, -1e9], [-3e18, 3e18], [1e30, 1e30]])
    for number in range(3):
        got = results(sample_kernel, 3, [device_scene.data, number, column(uv, wp.vec2)], wp.vec4)
        assert np.isfinite(got).all()
        assert (got >= 0.0).all()
        assert (got <= 1.0).all()


def test_the_slot_chooses_its_uv_set_and_row_0_is_v_0() -> None:
    pixels = np.zeros((2, 1, 4), np.uint8)
    pixels[0, 0], pixels[1, 0] = (255, 0, 0, 255), (0, 255, 0, 64)
    part = quad([0, 0, 0], [1, 0, 0], [0, 1, 0])
    second = np.array([[0, 0.25], [0, 0.25], [0, 0.75], [0, 0.75]])
    part = type(part)(part.positions, part.triangles, uvs=(np.full((4, 2), 0.5), second))
    slot = TextureSlot(0, 1)
    material = Material(base_color=(1.0, 1.0, 1.0, 0.5), base_color_slot=slot, alpha_mode=AlphaMode.BLEND)
    device_scene = resident_of([part], [material], textures=[Texture("two", pixels, srgb=True, nearest=True)])
    places = column([[0.99, 0.005], [0.005, 0.005]], wp.vec2)  # near the triangle's first and last corner
    colours = results(slot_kernel, 2, [device_scene.data, places], wp.vec4)
    assert np.allclose(colours, [[1, 0, 0, 1], [0, 1, 0, 64 / 255]], atol=1e-6)
    alphas = results(alpha_kernel, 2, [device_scene.data, places], float)
    assert np.allclose(alphas, [0.5, 0.5 * 64 / 255], atol=1e-6)
