"""Ends of light paths on surfaces, found and put in order on the device; how many paths leave as many as wanted."""

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.device import launch, overwrite
from gpu.core.morton import EMPTY_KEY, morton_key
from gpu.core.radix_sort import iota_kernel
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls, allocate_vpls, light_path_kernel
from gpu.lights.light_table import LightTable
from gpu.lights.portals import Portals, no_portals


@wp.kernel
def surface_key_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], flux: wp.array[wp.vec3],
                       keys: wp.array[int]) -> None:  # fmt: skip
    """One thread a VPL or photon: its key in the order of surface points, EMPTY_KEY without flux; (vpl,) each."""
    index = first + wp.tid()
    carried = flux[index]
    keys[index] = EMPTY_KEY
    if carried[0] + carried[1] + carried[2] > 0.0:
        keys[index] = morton_key(position[index], normal[index])


@wp.kernel
def gather_vpls_kernel(first: int, order: wp.array[int], vpls: Vpls, out: Vpls) -> None:
    """One thread a VPL: copies the one that comes there in `order`."""
    index = first + wp.tid()
    source = order[index]
    out.position[index] = vpls.position[source]
    out.normal[index] = vpls.normal[source]
    out.to_light[index] = vpls.to_light[source]
    out.flux[index] = vpls.flux[source]
    out.bounce[index] = vpls.bounce[source]
    out.light[index] = vpls.light[source]


@wp.kernel
def count_filled_kernel(first: int, sorted_keys: wp.array[int], filled: wp.array[int]) -> None:
    """One thread a key: where the first is empty, writes how many are not.

    sorted_keys (key,): of `surface_key_kernel`; filled (1,): before, how many there are.
    """
    index = first + wp.tid()
    if sorted_keys[index] == EMPTY_KEY:
        if index == 0:
            filled[0] = 0
        elif sorted_keys[index - 1] != EMPTY_KEY:
            filled[0] = index


class PathEnds:
    """Where light paths of at most `bounces` hits meet surfaces, found and put in order on the device.

    raw: the places by path, flux 0 where there is none; order (2 · place,): the first `filled` (1,) are those with
    flux, neighbours on a surface side by side; room: for paths; portals: that paths are drawn through, none at first;
    no_seed (1,): 0. All is allocated once.
    """

    def __init__(self, room: int, bounces: int, device: wp.Device, *, arriving: bool) -> None:
        """room: how many paths there are, unless `set_paths` says fewer; arriving: whether flux is what arrives, as
        photons have it, else what is reflected.
        """
        self.room, self._bounces, self._arriving, self.device = room, bounces, arriving, device
        self.capacity = room * bounces
        self._paths = wp.full(1, room, dtype=int, device=device)
        self.no_seed = wp.zeros(1, dtype=int, device=device)
        self.portals = no_portals(device)
        self.raw = allocate_vpls(self.capacity, device)
        self.order = wp.zeros(2 * self.capacity, dtype=int, device=device)
        self.filled = wp.zeros(1, dtype=int, device=device)
        self._count = StagingBuffer(self.filled)
        self._keys = wp.zeros(2 * self.capacity, dtype=int, device=device)

    def set_paths(self, paths: int) -> None:
        """Have so many paths from now on, for which there is room."""
        self._paths.fill_(paths)

    def go_through(self, portals: "Portals | None") -> None:
        """Have paths drawn through these from now on."""
        if portals is None:
            self.portals.count.zero_()
        else:
            overwrite(Portals, self.portals, portals)

    def trace(self, scene: SceneData, table: LightTable, seed: wp.array, features: SceneFeatures) -> None:
        """Trace new paths by `seed` (1,)."""
        kernel = light_path_kernel(features, self._arriving)
        inputs = [scene, table, self._paths, self._bounces, seed, self.portals, self.raw]
        launch(kernel, self.room, inputs, self.device)
        self.put_in_order()

    def put_in_order(self) -> None:
        """Find `order` and `filled` of the places that are in `raw`."""
        raw, keys, order, capacity = self.raw, self._keys, self.order, self.capacity
        launch(surface_key_kernel, capacity, [raw.position, raw.normal, raw.flux, keys], self.device)
        launch(iota_kernel, capacity, [order], self.device)
        radix_sort_pairs(keys, order, capacity)
        self.filled.fill_(capacity)
        launch(count_filled_kernel, capacity, [keys, self.filled], self.device)

    def count(self) -> int:
        """How many places are `filled`. The host waits for the device's current stream, and for no other."""
        self._count.download()
        wp.synchronize_stream(self.device)
        return int(self._count.host[0])


PILOT_PATHS = 4096
"""Of a pilot run."""


def pilot_of(bounces: int, device: wp.Device, paths: int = PILOT_PATHS, *, arriving: bool = False) -> PathEnds:
    """What a pilot run works with. arriving: photons are wanted, which black surfaces have, too, not VPLs."""
    return PathEnds(paths, bounces, device, arriving=arriving)


def paths_for(device_scene: DeviceScene, scene: SceneData, table: LightTable, wanted: int, bounces: int,
              features: SceneFeatures, *, pilot: PathEnds | None = None,
              max_paths_per_vpl: int = 16) -> int:  # fmt: skip
    """How many light paths leave about `wanted` VPLs, by a run of a few; none when there is no light.

    pilot: of `pilot_of`, where it is kept or photons are wanted; max_paths_per_vpl: no more are traced for each,
    however few of them meet a surface.
    """
    if table.count == 0:
        return 0
    pilot = pilot or pilot_of(bounces, device_scene.device)
    # An array that goes is freed on a stream that all others wait for.
    pilot.trace(scene, table, pilot.no_seed, features)
    return paths_that_leave(wanted, pilot.count() / pilot.room, max_paths_per_vpl)


def paths_that_leave(wanted: int, per_path: float, max_paths_per_vpl: int = 16) -> int:
    """How many light paths leave about `wanted` VPLs where one leaves `per_path` in the mean, as for `paths_for`."""
    return max(1, round(wanted / max(per_path, 1.0 / max_paths_per_vpl)))
