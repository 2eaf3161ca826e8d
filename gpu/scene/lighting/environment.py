"""The light from all around that a picture shows: `--environment`."""

from pathlib import Path

import numpy as np

from gpu.errors import ImageError
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.lighting.exr_picture import read_exr
from gpu.scene.lighting.radiance_hdr import read_radiance
from gpu.scene.lighting.surroundings import surrounded
from gpu.scene.types import Environment, Floats, Scene

SUFFIXES = (".hdr", ".exr")
MOST_PIXELS = 1 << 26
_WIDEST = 4096  # what is wider is made smaller: rays are drawn by its pixels
_MOST = 1e6  # radiance, so that float32 holds what is computed with it


def with_environment(scene: Scene, options: EnvironmentOptions) -> Scene:
    """`scene` `surrounded` by the environment that `options` name; ImageError where that cannot be read."""
    if options.environment is None:
        return scene
    pixels = read_environment(options.environment)
    turn = options.environment_rotation / 360.0
    strength = np.float32(options.environment_strength)
    return surrounded(scene, Environment(options.environment.name, pixels * strength, turn))


def read_environment(path: Path) -> Floats:
    """Linear radiance (height, width, 3) of a picture, at most 4096 wide, finite and not negative.

    Raises ImageError where it cannot be read, is not twice as wide as high, or shows no light.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ImageError(f"{path}: is no picture of an environment; give one that ends in {' or '.join(SUFFIXES)}")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ImageError(f"{path}: cannot be read: {error.strerror}") from error
    hdr = path.suffix.lower() == ".hdr"
    pixels = read_radiance(content, str(path), MOST_PIXELS) if hdr else read_exr(path, MOST_PIXELS)
    height, width = pixels.shape[:2]
    if width != 2 * height:
        raise ImageError(f"{path}: is {width} x {height}; an equirectangular picture is twice as wide as high")
    pixels = np.clip(np.nan_to_num(pixels, nan=0.0, posinf=_MOST, neginf=0.0), 0.0, _MOST)
    if not pixels.any():
        raise ImageError(f"{path}: is all black, so it gives no light")
    return _at_most(np.ascontiguousarray(pixels, np.float32), _WIDEST)


def _at_most(pixels: Floats, width: int) -> Floats:
    """Pixels (height, width, 3), made smaller by the least whole factor with which they are at most `width` wide."""
    factor = -(-pixels.shape[1] // width)
    rows, columns = pixels.shape[0] // factor, pixels.shape[1] // factor
    if factor == 1:
        return pixels
    cut = pixels[: rows * factor, : columns * factor].reshape(rows, factor, columns, factor, 3)
    return np.asarray(cut.mean(axis=(1, 3)), np.float32)
