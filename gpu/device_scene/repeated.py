"""Which triangles lie in the place of others, corner on corner.

A ray that passes one passes all of them, whatever tree they are in: a million in one place, which are a file of a few
megabytes, take a ray as long as a million tests. One of them shows all that there is to see: rays meet them to the bit
alike, and of such the first one (gpu.device_scene.bvh), so that a tree that has all of them shows the same.
"""

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.device import launch
from gpu.core.radix_sort import iota_kernel, running_total
from gpu.device_scene.data import SceneData

NO_TWIN = wp.constant(-1)


@wp.func
def mixed(number: wp.uint64) -> wp.uint64:
    """Each bit of the result depends on every bit: the steps of SplitMix64 (Steele, Lea, Flood 2014)."""
    z = number + wp.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> wp.uint64(30))) * wp.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> wp.uint64(27))) * wp.uint64(0x94D049BB133111EB)
    return z ^ (z >> wp.uint64(31))


@wp.func
def with_value(key: wp.uint64, value: float) -> wp.uint64:
    """A key that depends on one more value; on -0 as on 0, which are equal."""
    return mixed(key + wp.uint64(wp.cast(wp.where(value == 0.0, 0.0, value), wp.uint32)))


@wp.func
def corner_key(scene: SceneData, vertex: int, looks: bool) -> wp.uint64:
    """A number that is the same for equal corners, and rarely for others. looks: see `distinct`."""
    key = wp.uint64(0)
    for axis in range(3):
        key = with_value(key, scene.vertices[vertex][axis])
    if looks:
        for uv_set in range(scene.uvs.shape[0]):
            key = with_value(with_value(key, scene.uvs[uv_set, vertex][0]), scene.uvs[uv_set, vertex][1])
        if scene.has_colors:
            for channel in range(4):
                key = with_value(key, scene.colors[vertex][channel])
    return key


@wp.func
def equal_corners(scene: SceneData, one: int, other: int, looks: bool) -> bool:
    """Whether two vertices have equal values."""
    equal = scene.vertices[one] == scene.vertices[other]
    if looks:
        for uv_set in range(scene.uvs.shape[0]):
            equal = equal and scene.uvs[uv_set, one] == scene.uvs[uv_set, other]
        if scene.has_colors:
            equal = equal and scene.colors[one] == scene.colors[other]
    return equal


@wp.func
def equal_triangles(scene: SceneData, one: int, other: int, looks: bool) -> bool:
    """Whether two triangles have one material and equal corners in the same order."""
    if scene.triangle_material[one] != scene.triangle_material[other]:
        return False
    a = scene.triangles[one]
    b = scene.triangles[other]
    equal = equal_corners(scene, a[0], b[0], looks) and equal_corners(scene, a[1], b[1], looks)
    return equal and equal_corners(scene, a[2], b[2], looks)


@wp.kernel
def triangle_key_kernel(first: int, scene: SceneData, begin: int, looks: bool, keys: wp.array[wp.uint64]) -> None:
    """One thread a triangle, numbered from `begin`: its key, keys (triangle,), the same for equal triangles."""
    number = first + wp.tid()
    corner = scene.triangles[begin + number]
    a = corner_key(scene, corner[0], looks)
    b = corner_key(scene, corner[1], looks)
    c = corner_key(scene, corner[2], looks)
    three = wp.uint64(3)
    keys[number] = mixed(three * (three * a + b) + c) + mixed(wp.uint64(scene.triangle_material[begin + number]))


@wp.kernel
def twin_kernel(first: int, scene: SceneData, begin: int, looks: bool, keys: wp.array[wp.uint64],
                order: wp.array[int], twins: wp.array[int], kept: wp.array[int]) -> None:  # fmt: skip
    """One thread a place in the `order` (place,) of ascending `keys` (place,): one of those before that its triangle
    equals, or NO_TWIN: twins (triangle,), where kept (triangle,) is 1, else 0.
    """
    place = first + wp.tid()
    number = order[place]
    twins[number] = NO_TWIN
    kept[number] = 1
    if place == 0:
        return
    if keys[place] != keys[place - 1]:
        return
    if equal_triangles(scene, begin + number, begin + order[place - 1], looks):
        twins[number] = order[place - 1]
        kept[number] = 0


@wp.kernel
def list_kept_kernel(first: int, kept: wp.array[int], totals: wp.array[int], listed: wp.array[int]) -> None:
    """One thread a triangle: lists it where it is `kept` (triangle,). totals (triangle,): the running sum of that."""
    number = first + wp.tid()
    if kept[number] == 1:
        listed[totals[number] - 1] = number


def distinct(scene: SceneData, begin: int, end: int, *, looks: bool) -> tuple[wp.array, wp.array]:
    """The triangles from `begin` to `end`, numbered from `begin` and ascending, of which none equals an earlier one: by
    its material and the positions of its corners; looks: by all else but their normals, too. And, of each, one that it
    equals, or NO_TWIN: those that lie in one place form a chain.
    """
    count, device = end - begin, scene.vertices.device
    keys = wp.empty(2 * count, dtype=wp.uint64, device=device)
    order, twins, kept, totals = (wp.empty(size, dtype=int, device=device) for size in (2 * count, *3 * (count,)))
    launch(triangle_key_kernel, count, [scene, begin, looks, keys], device)
    launch(iota_kernel, count, [order], device)
    radix_sort_pairs(keys, order, count)
    launch(twin_kernel, count, [scene, begin, looks, keys, order, twins, kept], device)
    running_total(kept, totals)
    listed = wp.empty(int(totals[-1:].numpy()[0]), dtype=int, device=device)
    launch(list_kept_kernel, count, [kept, totals, listed], device)
    return listed, twins
