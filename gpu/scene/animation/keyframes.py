"""Values between the keys of an animation (glTF 2.0, Appendix C)."""

import numpy as np

from gpu.scene.animation.motion import Channel, Interpolation, Property
from gpu.scene.types import Doubles

_NEARLY_ONE = 1.0 - 1e-9  # the cosine of the angle between two rotations below which there is an arc


def value_at(channel: Channel, time: float) -> Doubles:
    """What `channel` says at `time` [s], (component,); before its first key that one, after its last that one."""
    times, values = channel.times, channel.values
    key = int(np.searchsorted(times, time, side="right")) - 1
    middle = values.shape[1] // 2
    if key < 0 or key == len(times) - 1 or time == times[key] or channel.interpolation is Interpolation.STEP:
        return np.asarray(values[max(key, 0), middle])
    step = float(times[key + 1] - times[key])
    share = float(time - times[key]) / step
    if channel.interpolation is Interpolation.CUBICSPLINE:
        return _spline(values[key], values[key + 1], share, step)
    if channel.changes is Property.ROTATION:
        return _arc(values[key, 0], values[key + 1, 0], share)
    return np.asarray((1.0 - share) * values[key, 0] + share * values[key + 1, 0])


def _spline(begin: Doubles, end: Doubles, share: float, step: float) -> Doubles:
    """Between two keys (tangent towards it, value, tangent from it) that are `step` seconds apart (C.4)."""
    square, cube = share**2, share**3
    return np.asarray(
        (2.0 * cube - 3.0 * square + 1.0) * begin[1]
        + step * (cube - 2.0 * square + share) * begin[2]
        + (3.0 * square - 2.0 * cube) * end[1]
        + step * (cube - square) * end[0]
    )


def _arc(begin: Doubles, end: Doubles, share: float) -> Doubles:
    """Between two rotations the short way at an even pace (C.3); one without a direction is left as it is."""
    lengths = float(np.linalg.norm(begin)), float(np.linalg.norm(end))
    if min(lengths) == 0.0:
        return begin
    begin, end = begin / lengths[0], end / lengths[1]
    cosine = float(begin @ end)
    if cosine < 0.0:
        end, cosine = -end, -cosine
    if cosine > _NEARLY_ONE:
        return np.asarray((1.0 - share) * begin + share * end)
    angle = np.arccos(cosine)
    return np.asarray((np.sin((1.0 - share) * angle) * begin + np.sin(share * angle) * end) / np.sin(angle))
