"""Procedural images: deterministic, seamless where they repeat, 8-bit sRGB of shape (height, width, 4).

Colours are "#rrggbb" in sRGB, several in one string with spaces between. Every pixel is kept within albedos of 0.05 to
0.85, as real materials are.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from gpu.scene.types import Bytes, Doubles

LEAST_ALBEDO, MOST_ALBEDO = 0.05, 0.85
_DARKEST, _LIGHTEST = 64, 236  # their sRGB, rounded inwards


def palette(colours: str) -> Doubles:
    """The sRGB values (colour, 3) in 0 to 1 of "#rrggbb #rrggbb …"."""
    return np.array([list(bytes.fromhex(colour[1:])) for colour in colours.split()]) / 255.0


def forget() -> None:
    """Free what images have shared."""
    _gain.cache_clear()
    _weave.cache_clear()


def image(colours: Doubles) -> Bytes:
    """Pixels of sRGB values (height, width, 3) in 0 to 1."""
    pixels = np.full((*colours.shape[:2], 4), 255, np.uint8)
    pixels[..., :3] = np.clip(np.round(colours * 255.0), _DARKEST, _LIGHTEST)
    return pixels


@lru_cache(maxsize=16)
def _gain(size: int, slope: float, stretch: tuple[float, float], low: float) -> Doubles:
    """Of the frequencies (size, size // 2 + 1) of `noise`, which many images share."""
    across = np.fft.rfftfreq(size, 1.0 / size) * stretch[0]
    down = np.fft.fftfreq(size, 1.0 / size)[:, None] * stretch[1]
    frequency = np.hypot(across, down)
    return np.asarray(np.where(frequency >= low, np.maximum(frequency, low), np.inf) ** -slope)


def noise(
    size: int, seed: int, slope: float = 1.5, stretch: tuple[float, float] = (1.0, 1.0), low: float = 1.0
) -> Doubles:
    """Seamless noise (size, size) of mean 0 and deviation 1 whose amplitude falls with frequency to the power `slope`.

    stretch: how much longer its features are along u and v; low: frequencies below it, in cycles an image, are cut.
    """
    white = np.fft.rfft2(np.random.default_rng(seed).standard_normal((size, size)))
    values = np.fft.irfft2(white * _gain(size, slope, stretch, low), (size, size))
    return np.asarray(values / values.std())


def ramp(values: Doubles, colours: str) -> Doubles:
    """The sRGB values (height, width, 3) from `values` along evenly spaced `colours`; clipped to 0 to 1."""
    table = palette(colours)
    stops = np.linspace(0.0, 1.0, len(table))
    return np.stack([np.interp(values, stops, channel) for channel in table.T], axis=-1)


def _grain(size: int, seed: int) -> Doubles:
    """Wood grain along u, in 0 to 1."""
    rings = np.sin(5.0 * noise(size, seed, 1.6, (12.0, 1.0), 2.0) + noise(size, seed + 1, 1.0, (30.0, 1.0)))
    pores = noise(size, seed + 2, 0.3, (60.0, 1.0))
    return np.clip(0.5 + 0.24 * rings + 0.11 * pores, 0.0, 1.0)


def wood(seed: int, colours: str, size: int = 512) -> Bytes:
    """Grain along u in `colours` from dark to light."""
    return image(ramp(_grain(size, seed), colours))


def planks(seed: int, colours: str, rows: int = 8, columns: int = 2, size: int = 1024) -> Bytes:
    """A floor of `rows` boards along u, `columns` an image, each row shifted, each board of its own piece and tint."""
    rng = np.random.default_rng(seed)
    grain = _grain(size, seed)
    v, u = np.mgrid[0:size, 0:size]
    row = v * rows // size
    along = (u + rng.integers(0, size, rows)[row]) % size
    board = row * columns + along * columns // size
    shade = rng.normal(0.0, 0.09, rows * columns)[board]
    piece = grain[v, (u + rng.integers(0, size, rows * columns)[board]) % size]
    colours_of = ramp(0.5 + 0.75 * (piece - 0.5) + shade, colours)
    edge = np.minimum(v * rows % size / rows, size / rows - 1 - v * rows % size / rows)
    end = along * columns % size / columns
    return image(colours_of * np.where((edge < 1.0) | (end < 1.5), 0.55, 1.0)[..., None])


def marble(seed: int, colours: str, veins: float = 0.8, size: int = 512) -> Bytes:
    """Clouded stone in `colours` from vein to ground."""
    sharp = np.exp(-9.0 * np.abs(noise(size, seed, 1.9))) * np.clip(0.55 + 0.5 * noise(size, seed + 1, 1.6), 0.0, 1.0)
    return image(ramp(0.8 + 0.12 * noise(size, seed + 2, 1.6) - veins * sharp, colours))


def tiles(seed: int, stones: Sequence[str], count: int, joint: str, size: int = 1024) -> Bytes:
    """`count` × `count` square tiles, cut by chance from marbles in the colours of `stones` in turns, with a joint."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:size, 0:size]
    row, column = v * count // size, u * count // size
    du, dv = rng.integers(0, size // 2, (2, count, count))[:, row, column]
    slabs = np.stack([marble(seed + 3 * number, colours) for number, colours in enumerate(stones)])[..., :3] / 255.0
    colours = slabs[(row + column) % len(stones), (v + dv) % 512, (u + du) % 512]
    colours = colours * rng.normal(1.0, 0.035, (count, count))[row, column][..., None]
    edge = (u * count % size < 2 * count) | (v * count % size < 2 * count)
    return image(np.where(edge[..., None], palette(joint), colours))


def plaster(seed: int, colour: str, amount: float = 0.02, size: int = 512) -> Bytes:
    """A painted wall: `colour` with a faint trowel pattern of relative deviation `amount`."""
    cloud = 0.7 * noise(size, seed, 1.4, low=2.0) + 0.5 * noise(size, seed + 1, 0.6)
    return image(palette(colour) * (1.0 + amount * cloud)[..., None])


@lru_cache(maxsize=2)
def _weave(threads: int, size: int) -> Doubles:
    """The light (size, size) of a plain weave."""
    v, u = np.mgrid[0:size, 0:size] * (2.0 * np.pi * threads / size)
    crossing = np.sin(u / 2) * np.sin(v / 2)
    return np.asarray(0.5 + 0.25 * crossing * np.sign(crossing) - 0.1 * np.cos(u) * np.cos(v))


def fabric(seed: int, colours: str, threads: int = 64, size: int = 512) -> Bytes:
    """A plain weave of `threads` an image in `colours` from shadow to light."""
    weave = _weave(threads, size)
    return image(ramp(weave + 0.1 * noise(size, seed, 0.4) + 0.05 * noise(size, seed + 1), colours))


def carpet(seed: int, colours: str, tiles: int = 2, size: int = 512) -> Bytes:
    """`tiles` × `tiles` carpet tiles of loop pile, laid with the pile in turns along u and v."""
    v, u = np.mgrid[0:size, 0:size]
    other = (u * tiles // size + v * tiles // size) % 2 == 1
    across, down = noise(size, seed, 0.5, (6.0, 1.0), 4.0), noise(size, seed + 1, 0.5, (1.0, 6.0), 4.0)
    pile = np.where(other, across, down) * 0.12 + 0.1 * noise(size, seed + 2, 0.1) + np.where(other, 0.03, -0.03)
    seam = (u * tiles % size < tiles) | (v * tiles % size < tiles)
    return image(ramp(0.5 + pile - 0.12 * seam, colours))


def leaves(seed: int, colours: str, size: int = 256) -> Bytes:
    """A leaf along v: a pale midrib, side veins and blotches in `colours` from dark to light."""
    v, u = np.mgrid[0:size, 0:size] / size
    side = np.abs(u - 0.5)
    veins = np.exp(-side * 60.0) * 0.4 + 0.08 * np.cos((v - side * 1.2) * 2 * np.pi * 12)
    return image(ramp(0.4 + veins + 0.08 * noise(size, seed), colours))


def book_spines(seed: int, cloths: str, count: int = 32, size: int = 512) -> Bytes:
    """An atlas of `count` upright book spines side by side, each a cloth with bands and a title in gold or white."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:size, 0:size] / size
    book = (u * count).astype(int)
    within = u * count - book
    cloth = palette(cloths)
    cloth = cloth[rng.integers(0, len(cloth), count)]
    cloth = np.clip(cloth * rng.normal(1.0, 0.08, (count, 1)), 0.0, 1.0)
    print_colour = np.where(rng.random((count, 1)) < 0.6, palette("#d8b878"), palette("#e8e2d4"))
    band_at, label_at = rng.uniform(0.06, 0.2, count)[book], rng.uniform(0.3, 0.45, count)[book]
    length, label = rng.uniform(0.15, 0.3, count)[book], (rng.random(count) < 0.35)[book]
    bands = (np.abs(v - band_at) < 0.008) | (np.abs(v - 1 + band_at) < 0.008)
    letters = (np.sin(v * 190 + book) + np.sin(v * 71 + 2 * book) > 0.2) & (np.abs(within - 0.5) < 0.16)
    title = (v > label_at) & (v < label_at + length)
    plate = title & label & (np.abs(within - 0.5) < 0.36)
    colours = np.where(plate[..., None], cloth[book] * 0.6, cloth[book])
    colours = np.where((bands | (title & letters))[..., None], print_colour[book], colours)
    shade = 1.0 - 0.25 * (2 * within - 1) ** 4 + 0.02 * noise(size, seed)
    return image(colours * shade[..., None])


def kilim(seed: int, colours: str, size: int = 512) -> Bytes:
    """A woven rug of stepped diamonds within a border; colours: field, border, and those of the diamonds."""
    v, u = np.floor(np.mgrid[0:size, 0:size] / size * 96) / 96
    edge = np.minimum(np.minimum(u, 1 - 1 / 96 - u), np.minimum(v, 1 - 1 / 96 - v))
    diamond = np.abs((u * 3) % 1 - 0.5) + np.abs((v * 4) % 1 - 0.5)
    ring = np.clip((diamond * 7).astype(int), 0, 6)
    dyes = palette(colours)
    index = np.array([2, 0, 3, 4, 0, 2, 0])[ring] % len(dyes)
    index = np.where(edge < 0.08, 1, index)
    index = np.where((edge > 0.035) & (edge < 0.05) & ((u * 48 + v * 48).astype(int) % 2 == 0), 3 % len(dyes), index)
    weave = 1.0 + 0.05 * noise(size, seed, 0.5, (1.0, 4.0)) + 0.03 * noise(size, seed + 1)
    return image(dyes[index] * weave[..., None])
