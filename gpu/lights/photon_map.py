"""The global photon map: where light paths from the emitters meet surfaces (H. W. Jensen, Global Illumination using
Photon Maps, 1996; 2009 paper, section 3.1).

It is traced and sorted anew in each frame, without leaving the device.
"""

import warp as wp

from gpu.core.device import allocate, launch
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.lights.light_paths import Vpls
from gpu.lights.light_table import LightTable
from gpu.lights.path_ends import PathEnds


@wp.struct
class Photons:
    """Photons in Morton order, those of one side of a surface together.

    position, normal (photon,): where one arrives in unit space, the geometric normal on the side that it arrives from,
    of what is translucent on the side that it leaves; flux (photon,): what it brings, before anything is reflected [W];
    bounce (photon,): how many surfaces its path met before; count (1,): how many there are; places beyond hold nothing.
    bounces: that paths have at most.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    bounce: wp.array[int]
    count: wp.array[int]
    bounces: int


@wp.kernel
def gather_photons_kernel(first: int, order: wp.array[int], raw: Vpls, out: Photons) -> None:
    """One thread a photon: copies the one that comes there in `order`."""
    index = first + wp.tid()
    if index >= out.count[0]:
        return
    source = order[index]
    out.position[index] = raw.position[source]
    out.normal[index] = raw.normal[source]
    out.flux[index] = raw.flux[source]
    out.bounce[index] = raw.bounce[source]


class PhotonMap:
    """The photons of `paths` light paths of at most `bounces` hits; `photons` after `trace`. All is allocated once."""

    def __init__(self, paths: int, bounces: int, device: wp.Device) -> None:
        self._ends = PathEnds(paths, bounces, device, arriving=True)
        self.capacity = self._ends.capacity
        self.photons: Photons = allocate(Photons, self.capacity, device)
        self.photons.count, self.photons.bounces = self._ends.filled, bounces

    def trace(self, scene: SceneData, table: LightTable, seed: wp.array, features: SceneFeatures) -> None:
        """Trace and sort new photons by `seed` (1,)."""
        ends = self._ends
        ends.trace(scene, table, seed, features)
        launch(gather_photons_kernel, self.capacity, [ends.order, ends.raw, self.photons], ends.device)
