"""Textures read on the host as gpu.device_scene.textures reads them on a device."""

import numpy as np

from gpu.scene.colors import srgb_to_linear
from gpu.scene.types import Doubles, Ints, Texture, TextureSlot, Wrap


def sample_texture(texture: Texture, slot: TextureSlot, uvs: Doubles) -> Doubles:
    """Linear RGBA (point, 4) of `texture` where `slot` puts the vertex coordinates `uvs` (point, 2)."""
    height, width, _ = texture.pixels.shape
    rows = np.reshape(slot.transform, (2, 3))
    s, t = rows[:, :2] @ uvs.T + rows[:, 2:]
    x, y = _scaled(s, width, texture.wrap_s), _scaled(t, height, texture.wrap_t)
    if texture.nearest:
        return _texels(texture, np.floor(x), np.floor(y))
    left, top = np.floor(x - 0.5), np.floor(y - 0.5)
    across, down = (x - 0.5 - left)[:, None], (y - 0.5 - top)[:, None]
    upper = _texels(texture, left, top) * (1.0 - across) + _texels(texture, left + 1.0, top) * across
    lower = _texels(texture, left, top + 1.0) * (1.0 - across) + _texels(texture, left + 1.0, top + 1.0) * across
    return np.asarray(upper * (1.0 - down) + lower * down)


def _scaled(coordinate: Doubles, size: int, wrap: Wrap) -> Doubles:
    """Texture coordinates in texels, folded so that even huge ones are exact enough."""
    if wrap is Wrap.CLAMP:
        return np.clip(coordinate, 0.0, 1.0) * size
    return (coordinate - 2.0 * np.floor(0.5 * coordinate)) * size


def _texels(texture: Texture, x: Doubles, y: Doubles) -> Doubles:
    """Texels (point, 4) at whole columns and rows, wrapped, as linear RGBA."""
    height, width, _ = texture.pixels.shape
    levels = texture.pixels[_wrapped(y, height, texture.wrap_t), _wrapped(x, width, texture.wrap_s)]
    linear = levels / 255.0
    if texture.srgb:
        linear[:, :3] = srgb_to_linear(levels[:, :3])
    return linear


def _wrapped(index: Doubles, size: int, wrap: Wrap) -> Ints:
    if wrap is Wrap.CLAMP:
        return np.clip(index, 0, size - 1).astype(np.int32)
    rest = index % (2 * size if wrap is Wrap.MIRROR else size)
    return np.where(rest < size, rest, 2 * size - 1 - rest).astype(np.int32)
