"""Procedural paintings for the walls, as images of textures.py."""

import numpy as np

from gpu.scene.builtin.textures import image, noise, palette, ramp
from gpu.scene.types import Bytes


def landscape(seed: int, sky: str, hills: str, size: int = 512) -> Bytes:
    """Hills in the colours `hills`, far to near, under a sky in the colours `sky`, top to horizon, with a sun."""
    v, u = np.mgrid[0:size, 0:size] / size
    strokes = noise(size, seed, 1.1, (6.0, 1.0))
    colours = ramp(v * 1.6 + 0.03 * strokes, sky)
    sun = np.hypot(u - 0.68, v - 0.3)
    glow = np.exp(-np.maximum(sun - 0.055, 0.0) * 12)[..., None]
    colours += (palette("#fff0c8") - colours) * glow * 0.85
    slopes = palette(hills)
    for number, slope in enumerate(slopes):
        far = number / max(len(slopes) - 1, 1)
        ridge = noise(size, seed + 7 * number + 1, 1.8, (1.0, 1.0), 1.0)[0]
        crest = 0.46 + 0.36 * far + (0.03 + 0.02 * far) * ridge
        depth = (v - crest[None]) * 2.0
        shade = 1.0 + 0.1 * np.roll(strokes, 40 * number, axis=1) - 0.25 * np.clip(depth, 0.0, 1.0)
        colours = np.where((v > crest[None])[..., None], slope * shade[..., None], colours)
    return image(colours)


def blocks(seed: int, colours: str, size: int = 512) -> Bytes:
    """Soft-edged fields of colour on a ground of the first, after the colour-field painters."""
    rng, fields = np.random.default_rng(seed), palette(colours)
    v, u = np.mgrid[0:size, 0:size] / size
    fray = 0.012 * noise(size, seed, 1.3)
    picture = np.broadcast_to(fields[0], (size, size, 3)).copy()
    edges = np.linspace(0.07, 0.95, len(fields)) + np.append(0.0, rng.normal(0.0, 0.04, len(fields) - 1))
    edges[-1] = 0.94
    for colour, top, bottom in zip(fields[1:], edges[:-1], edges[1:], strict=True):
        inside = np.minimum(np.minimum(u - 0.09, 0.91 - u), np.minimum(v - top, bottom - 0.03 - v)) + fray
        cover = np.clip(inside * 45.0, 0.0, 1.0) * (0.9 + 0.05 * noise(size, seed + 3, 1.2))
        picture += (colour - picture) * np.clip(cover, 0.0, 1.0)[..., None]
    return image(picture * (1.0 + 0.03 * noise(size, seed + 9, 0.7))[..., None])


def strata(seed: int, colours: str, size: int = 512) -> Bytes:
    """Flowing bands of colour, as poured paint."""
    v, u = np.mgrid[0:size, 0:size] / size
    flow = 1.3 * v + 0.5 * u + 0.16 * noise(size, seed, 2.0) + 0.05 * noise(size, seed + 1, 1.5)
    band = np.abs((flow * 2.2) % 2.0 - 1.0)
    return image(ramp(band + 0.02 * noise(size, seed + 2, 0.8), colours))
