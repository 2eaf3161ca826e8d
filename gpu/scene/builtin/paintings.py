"""Procedural paintings for the walls, as images of textures.py."""

from collections.abc import Sequence

import numpy as np

from gpu.scene.builtin.textures import encoded, image, noise, ramp
from gpu.scene.types import Bytes


def landscape(seed: int, sky: Sequence[str], hills: Sequence[str], size: int = 512) -> Bytes:
    """Hills in the colours `hills`, far to near, under a sky in the colours `sky`, top to horizon, with a sun."""
    v, u = np.mgrid[0:size, 0:size] / size
    strokes = noise(size, seed, 1.1, (6.0, 1.0))
    colours = ramp(np.clip(v * 1.6 + 0.03 * strokes, 0.0, 1.0), sky)
    sun = np.hypot(u - 0.68, v - 0.3)
    glow = np.exp(-np.maximum(sun - 0.055, 0.0) * 12)[..., None]
    colours += (encoded("#fff0c8") - colours) * glow * 0.85
    for number, hill in enumerate(hills):
        far = number / max(len(hills) - 1, 1)
        ridge = noise(size, seed + 7 * number + 1, 1.8, (1.0, 1.0), 1.0)[0]
        crest = 0.46 + 0.36 * far + (0.03 + 0.02 * far) * ridge
        depth = (v - crest[None]) * 2.0
        shade = 1.0 + 0.1 * np.roll(strokes, 40 * number, axis=1) - 0.25 * np.clip(depth, 0.0, 1.0)
        colours = np.where((v > crest[None])[..., None], encoded(hill) * shade[..., None], colours)
    return image(colours)


def blocks(seed: int, colours: Sequence[str], size: int = 512) -> Bytes:
    """Soft-edged fields of colour on the ground colours[0], after the colour-field painters."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:size, 0:size] / size
    fray = 0.012 * noise(size, seed, 1.3)
    picture = np.broadcast_to(encoded(colours[0]), (size, size, 3)).copy()
    edges = np.linspace(0.07, 0.95, len(colours)) + np.append(0.0, rng.normal(0.0, 0.04, len(colours) - 1))
    edges[-1] = 0.94
    for colour, top, bottom in zip(colours[1:], edges[:-1], edges[1:], strict=True):
        inside = np.minimum(np.minimum(u - 0.09, 0.91 - u), np.minimum(v - top, bottom - 0.03 - v)) + fray
        cover = np.clip(inside * 45.0, 0.0, 1.0) * (0.9 + 0.05 * noise(size, seed + 3, 1.2))
        picture += (encoded(colour) - picture) * np.clip(cover, 0.0, 1.0)[..., None]
    return image(picture * (1.0 + 0.03 * noise(size, seed + 9, 0.7))[..., None])


def strata(seed: int, colours: Sequence[str], size: int = 512) -> Bytes:
    """Flowing bands of colour, as poured paint."""
    v, u = np.mgrid[0:size, 0:size] / size
    flow = 1.3 * v + 0.5 * u + 0.16 * noise(size, seed, 2.0) + 0.05 * noise(size, seed + 1, 1.5)
    band = np.abs((flow * 2.2) % 2.0 - 1.0)
    return image(ramp(np.clip(band + 0.02 * noise(size, seed + 2, 0.8), 0.0, 1.0), colours))
