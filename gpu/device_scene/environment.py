"""Light from all around by a picture: what it shows of a direction, and directions drawn by its brightness.

Rows are drawn by their share of the light, then pixels of the row by theirs (Pharr, Jakob and Humphreys, Physically
Based Rendering, 4th ed., 12.5.2). Within a pixel directions are uniform in solid angle.
"""

import numpy as np
import warp as wp

from gpu.core.constants import PI, TWO_PI
from gpu.core.search import upper_bound
from gpu.device_scene.data import EnvironmentData
from gpu.sampling.sobol import TO_UNIT, Pair
from gpu.scene.types import Doubles, Environment, Integers

# Of a row's or a pixel's mean brightness, so that none that interpolation lights is left without a chance.
_LEAST_SHARE = 1e-4
# What a pixel shows on the average of it and its neighbours, between whose middles colours are interpolated.
_TENT = (0.125, 0.75, 0.125)
_LUMINANCE = (0.2126, 0.7152, 0.0722)  # of linear Rec. 709


@wp.struct
class EnvironmentSample:
    """A unit direction to the environment and its density [1/sr]."""

    direction: wp.vec3
    density: float


@wp.func
def place_of(environment: EnvironmentData, direction: wp.vec3) -> wp.vec2:
    """Column and row [pixels], from the top left, of what unit `direction` sees."""
    azimuth = wp.atan2(direction[0], direction[2]) / TWO_PI - environment.turn
    across = 0.5 - azimuth
    across -= wp.floor(across)
    down = wp.acos(wp.clamp(direction[1], -1.0, 1.0)) / PI
    return wp.vec2(across * float(environment.width), down * float(environment.height))


@wp.func
def environment_radiance(environment: EnvironmentData, direction: wp.vec3) -> wp.vec3:
    """Radiance from unit `direction` [W/m²/sr] before it is tinted, interpolated between pixels."""
    place = place_of(environment, direction)
    x = place[0] - 0.5
    y = wp.clamp(place[1] - 0.5, 0.0, float(environment.height - 1))
    left = int(wp.floor(x))
    top = wp.min(int(wp.floor(y)), environment.height - 1)
    below = wp.min(top + 1, environment.height - 1)
    fx = x - float(left)
    fy = y - float(top)
    left = (left + environment.width) % environment.width
    right = (left + 1) % environment.width
    upper = environment.radiance[top, left] * (1.0 - fx) + environment.radiance[top, right] * fx
    lower = environment.radiance[below, left] * (1.0 - fx) + environment.radiance[below, right] * fx
    return upper * (1.0 - fy) + lower * fy


@wp.func
def share_at(ends: wp.array[wp.uint32], index: int) -> float:
    """The probability of element `index` of a choice whose elements end at `ends` of 2³²."""
    below = wp.uint32(0)
    if index > 0:
        below = ends[index - 1]
    return wp.max(float(ends[index] - below), 1.0) * TO_UNIT


@wp.func
def rest_of(ends: wp.array[wp.uint32], index: int, value: wp.uint32) -> float:
    """Where `value` is between the ends of element `index`, in [0, 1)."""
    below = wp.uint32(0)
    if index > 0:
        below = ends[index - 1]
    return float(value - below) / wp.max(float(ends[index] - below), 1.0)


@wp.func
def pixel_density(environment: EnvironmentData, row: int, column: int) -> float:
    """Density [1/sr] of directions to a pixel."""
    height = float(environment.height)
    band = wp.cos(PI * float(row) / height) - wp.cos(PI * float(row + 1) / height)
    share = share_at(environment.rows, row) * share_at(environment.columns[row], column)
    return share * float(environment.width) / (TWO_PI * band)


@wp.func
def environment_density(environment: EnvironmentData, direction: wp.vec3) -> float:
    """Density [1/sr] that `sample_environment` has in unit `direction`."""
    place = place_of(environment, direction)
    column = wp.min(int(place[0]), environment.width - 1)
    return pixel_density(environment, wp.min(int(place[1]), environment.height - 1), column)


@wp.func
def sample_environment(environment: EnvironmentData, place: Pair) -> EnvironmentSample:
    """A direction to the environment, by its brightness."""
    row = upper_bound(environment.rows, environment.height - 1, place.a)
    column = upper_bound(environment.columns[row], environment.width - 1, place.b)
    down = rest_of(environment.rows, row, place.a)
    across = (float(column) + rest_of(environment.columns[row], column, place.b)) / float(environment.width)
    top = wp.cos(PI * float(row) / float(environment.height))
    height = top + (wp.cos(PI * float(row + 1) / float(environment.height)) - top) * down
    azimuth = (0.5 - across + environment.turn) * TWO_PI
    radius = wp.sqrt(wp.max(1.0 - height * height, 0.0))
    sample = EnvironmentSample()
    sample.direction = wp.vec3(radius * wp.sin(azimuth), height, radius * wp.cos(azimuth))
    sample.density = pixel_density(environment, row, column)
    return sample


def mean_radiance(environment: Environment) -> float:
    """The mean over all directions and channels [W/m²/sr], before it is tinted."""
    return float((environment.pixels.astype(np.float64).mean(axis=(1, 2)) * _bands(len(environment.pixels))).sum())


def upload_environment(environment: Environment, device: wp.Device) -> EnvironmentData:
    """`environment` on a device, with the tables that directions are drawn by."""
    light = environment.pixels.astype(np.float64) @ np.array(_LUMINANCE)
    light = _smoothed(np.pad(light, ((0, 0), (1, 1)), "wrap"), 1)
    light = _smoothed(np.pad(light, ((1, 1), (0, 0)), "edge"), 0)
    light += _LEAST_SHARE * light.mean()
    data = EnvironmentData()
    data.height, data.width = light.shape
    data.turn, data.mean = environment.turn, wp.array([mean_radiance(environment)], dtype=float, device=device)
    data.radiance = wp.array(environment.pixels, dtype=wp.vec3, device=device)
    data.rows = wp.array(_ends(light.mean(axis=1) * _bands(len(light))), dtype=wp.uint32, device=device)
    data.columns = wp.array(_ends(light), dtype=wp.uint32, device=device)
    return data


def _smoothed(values: Doubles, axis: int) -> Doubles:
    """Values that are padded by one along `axis` as their means with their neighbours."""
    count = values.shape[axis] - 2
    parts = [np.take(values, range(k, k + count), axis) * weight for k, weight in enumerate(_TENT)]
    return np.asarray(sum(parts))


def _bands(rows: int) -> Doubles:
    """The shares of all directions that rows of a picture take, (row,)."""
    return np.asarray(-np.diff(np.cos(np.pi * np.arange(rows + 1) / rows)) / 2.0)


def _ends(shares: Doubles) -> Integers:
    """Where elements end, of 2³², in a choice by `shares` along the last axis."""
    ends = np.cumsum(shares, axis=-1)
    return np.minimum(np.floor(ends / ends[..., -1:] * 2.0**32), 2.0**32 - 1.0).astype(np.uint32)
