"""Emitters for tests of lights: a light of each kind, a room with a lamp, and the chances of being chosen."""

import warp as wp
from scenes import box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import PowerCdf, probability_of
from gpu.scene.types import Light, LightKind

DOWN = (0.0, -1.0, 0.0)
POINT = Light("point", LightKind.POINT, (1.0, 2.0, 3.0), position=(0.1, 0.2, -0.1))
SPOT = Light("spot", LightKind.SPOT, (4.0, 3.0, 2.0), direction=DOWN, cos_inner=0.9, cos_outer=0.6)
SUN = Light("sun", LightKind.DIRECTIONAL, (2.0, 1.0, 0.5), direction=(0.6, -0.8, 0.0))


@wp.kernel
def share_kernel(first: int, shares: PowerCdf, out: wp.array[float]) -> None:
    """One thread an emitter: the chance that it is chosen."""
    index = first + wp.tid()
    out[index] = probability_of(shares, index)


def lamp_room(**rest: object) -> DeviceScene:
    """A box of half a unit about the origin, with a lamp of radiance 3 and a fifth by a fifth under its ceiling."""
    lamp = quad([-0.1, 0.45, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    return resident_of([*box(), lamp], [grey(0.5), grey(0.0, emission=3.0)], **rest)
