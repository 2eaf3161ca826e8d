"""Makes a tree of four children a node (gpu.device_scene.bvh) of the binary one that Warp builds for a mesh.

Level by level: of a node's two children, the larger is opened until there are four.
"""

from functools import partial

import numpy as np
import warp as wp

from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.radix_sort import running_total
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.bvh import MAX_LEVELS, Bvh

NO_NODE = wp.constant(-1)
WIDTH = 4
# More are not told apart; fewer make more nodes.
LEAF_TRIANGLES = 2


@wp.func_native("return *wp::mesh_get(mesh).bvh.root;")
def root_of(mesh: wp.uint64) -> wp.int32:
    """The root of a mesh's binary tree."""


@wp.func_native("""
    const wp::BVH& tree = wp::mesh_get(mesh).bvh;
    return wp::vec_t<3, wp::int32>(tree.node_lowers[node].b, tree.node_lowers[node].i, tree.node_uppers[node].i);
""")
def entry_of(mesh: wp.uint64, node: int) -> wp.vec3i:
    """A node of a mesh's binary tree: (0, left, right) or, for a leaf, (1, first place, place after the last)."""


@wp.func_native("""
    const wp::BVHPackedNodeHalf corner = wp::mesh_get(mesh).bvh.node_lowers[node];
    return wp::vec3(corner.x, corner.y, corner.z);
""")
def lower_of(mesh: wp.uint64, node: int) -> wp.vec3:
    """The least corner of a node's box."""


@wp.func_native("""
    const wp::BVHPackedNodeHalf corner = wp::mesh_get(mesh).bvh.node_uppers[node];
    return wp::vec3(corner.x, corner.y, corner.z);
""")
def upper_of(mesh: wp.uint64, node: int) -> wp.vec3:
    """The greatest corner of a node's box."""


@wp.func_native("return wp::mesh_get(mesh).bvh.primitive_indices[place];")
def face_at(mesh: wp.uint64, place: int) -> wp.int32:
    """The triangle at a place of the leaves of a mesh's tree."""


@wp.func
def half_area(mesh: wp.uint64, node: int) -> float:
    """Half the surface of a node's box, -1 for a leaf, which cannot be opened."""
    if entry_of(mesh, node)[0] == 1:
        return -1.0
    size = upper_of(mesh, node) - lower_of(mesh, node)
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0]


@wp.kernel
def bvh_root_kernel(first: int, mesh: wp.uint64, nodes: wp.array[int]) -> None:
    """One thread: the only node of the first level."""
    nodes[first + wp.tid()] = root_of(mesh)


@wp.kernel
def bvh_open_kernel(
    first: int, mesh: wp.uint64, nodes: wp.array[int], slots: wp.array2d[int], inner: wp.array[int]
) -> None:
    """One thread a node of a level: its up to four children, and how many of them are no leaves.

    nodes (node,), slots (child, node): nodes of the binary tree, NO_NODE for none.
    """
    index = first + wp.tid()
    for slot in range(WIDTH):
        slots[slot, index] = NO_NODE
    slots[0, index] = nodes[index]
    number = int(1)
    while number < WIDTH:
        widest = int(-1)
        most = float(-1.0)
        for slot in range(number):
            area = half_area(mesh, slots[slot, index])
            if area > most:
                most = area
                widest = slot
        if widest < 0:
            break
        entry = entry_of(mesh, slots[widest, index])
        slots[widest, index] = entry[1]
        slots[number, index] = entry[2]
        number += 1
    total = int(0)
    for slot in range(number):
        total += 1 - entry_of(mesh, slots[slot, index])[0]
    inner[index] = total


@wp.kernel
def bvh_level_kernel(first: int, mesh: wp.uint64, slots: wp.array2d[int], inner: wp.array[int], totals: wp.array[int],
                     next_base: int, bounds: wp.array[wp.vec4], children: wp.array[wp.vec4i],
                     following: wp.array[int]) -> None:  # fmt: skip
    """One thread a node of a level: writes it, and lists those of its children that are of the next.

    next_base: the number of the next level's first node; bounds, children: of this level.
    """
    index = first + wp.tid()
    rank = totals[index] - inner[index]
    for slot in range(WIDTH):
        child = slots[slot, index]
        lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
        upper = lower
        target = int(NO_NODE)
        count = int(0)
        if child != NO_NODE:
            lower = lower_of(mesh, child)
            upper = upper_of(mesh, child)
            entry = entry_of(mesh, child)
            if entry[0] == 1:
                target = entry[1]
                count = entry[2] - entry[1]
            else:
                target = next_base + rank
                following[rank] = child
                rank += 1
        for axis in range(3):
            bounds[6 * index + 2 * axis][slot] = lower[axis]
            bounds[6 * index + 2 * axis + 1][slot] = upper[axis]
        children[2 * index][slot] = target
        children[2 * index + 1][slot] = count


@wp.kernel
def bvh_corner_kernel(first: int, mesh: wp.uint64, vertices: wp.array[wp.vec3], indices: wp.array[int],
                      culled: wp.array[float], corners: wp.array[wp.vec4], faces: wp.array[int]) -> None:  # fmt: skip
    """One thread a place of the leaves: its triangle and that one's corners. culled: see `build`."""
    place = first + wp.tid()
    face = face_at(mesh, place)
    faces[place] = face
    for corner in range(3):
        vertex = vertices[indices[3 * face + corner]]
        corners[3 * place + corner] = wp.vec4(vertex[0], vertex[1], vertex[2], culled[face])


def with_room(count: int) -> int:
    """A length for `count` rows and up to an eighth more, the same for most counts that are nearly the same."""
    step = 1 << max(count.bit_length() - 4, 0)
    return -(-count // step) * step


def _joined(parts: list[wp.array], length: int) -> wp.array:
    """Arrays one behind the other, and zeros after them up to a length."""
    whole = wp.zeros(length, dtype=parts[0].dtype, device=parts[0].device)
    begin = 0
    for part in parts:
        wp.copy(whole, part, dest_offset=begin, count=len(part))
        begin += len(part)
    return whole


def build(vertices: wp.array, indices: wp.array, culled: wp.array) -> Bvh:
    """A tree over one triangle or more, of `vertices` (vertex,) with corners `indices` (3·triangle,).

    There is room for some more nodes, so that one over what has moved a little mostly has arrays of the same sizes.

    culled (triangle,): 1 where the back can be culled, else 0.
    Raises RuntimeError if it has more levels than a ray's stack is made for.
    """
    device = vertices.device
    constructor = "cubql" if device.is_cuda else "sah"
    make = partial(wp.Mesh, vertices, indices, bvh_constructor=constructor, bvh_leaf_size=LEAF_TRIANGLES)
    mesh = make() if device.is_cuda else DEVICE_SHARING.beside(make)
    nodes = wp.empty(1, dtype=int, device=device)
    launch(bvh_root_kernel, 1, [mesh.id, nodes], device)
    bounds: list[wp.array] = []
    children: list[wp.array] = []
    base = 0
    while len(nodes) > 0:
        if len(bounds) == MAX_LEVELS:
            raise RuntimeError(f"the tree over {len(indices) // 3} triangles has more than {MAX_LEVELS} levels")
        count = len(nodes)
        slots = wp.empty((WIDTH, count), dtype=int, device=device)
        inner, totals = (wp.empty(count, dtype=int, device=device) for _ in range(2))
        launch(bvh_open_kernel, count, [mesh.id, nodes, slots, inner], device)
        running_total(inner, totals)
        following = wp.empty(int(totals[-1:].numpy()[0]), dtype=int, device=device)
        base += count
        bounds.append(wp.empty(6 * count, dtype=wp.vec4, device=device))
        children.append(wp.empty(2 * count, dtype=wp.vec4i, device=device))
        inputs = [mesh.id, slots, inner, totals, base, bounds[-1], children[-1], following]
        launch(bvh_level_kernel, count, inputs, device)
        nodes = following
    bvh = Bvh()
    room = with_room(base)
    bvh.bounds, bvh.children = _joined(bounds, 6 * room), _joined(children, 2 * room)
    starts = np.cumsum([0, *(len(level) // 2 for level in children)])
    # As long for every tree, so that one can take the place of another.
    bvh.levels = wp.array(np.pad(starts, (0, MAX_LEVELS + 1 - len(starts)), mode="edge"), dtype=int, device=device)
    bvh.faces = wp.empty(len(indices) // 3, dtype=int, device=device)
    bvh.corners = wp.empty(len(indices), dtype=wp.vec4, device=device)
    launch(bvh_corner_kernel, len(bvh.faces), [mesh.id, vertices, indices, culled, bvh.corners, bvh.faces], device)
    # What is read above goes with the mesh.
    wp.synchronize_device(device)
    return bvh
