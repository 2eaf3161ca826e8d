"""Makes a tree of four children a node (gpu.device_scene.bvh) of the binary one that Warp builds for a mesh."""

from functools import partial

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.binary_tree import BinaryTree, binary_tree, ordered
from gpu.device_scene.bvh import MAX_LEVELS, Bvh
from gpu.device_scene.bvh_collapse import WideTree, collapsed
from gpu.device_scene.bvh_reinsertion import reinsert
from gpu.scene.types import Ints

# Of the binary tree's leaves: more are not told apart.
LEAF_TRIANGLES = 2


@wp.func_native("return wp::mesh_get(mesh).bvh.primitive_indices[place];")
def face_at(mesh: wp.uint64, place: int) -> wp.int32:
    """The triangle at a place of the leaves of a mesh's tree."""


@wp.kernel
def bvh_corner_kernel(first: int, mesh: wp.uint64, places: wp.array[int], vertices: wp.array[wp.vec3],
                      indices: wp.array[int], culled: wp.array[float], corners: wp.array[wp.vec4],
                      faces: wp.array[int]) -> None:  # fmt: skip
    """One thread a place of the leaves: its triangle and that one's corners, faces and corners as of Bvh.

    places (place,): which of the mesh's each is; vertices, indices, culled: as of `build`.
    """
    place = first + wp.tid()
    face = face_at(mesh, places[place])
    faces[place] = face
    for corner in range(3):
        vertex = vertices[indices[3 * face + corner]]
        corners[3 * place + corner] = wp.vec4(vertex[0], vertex[1], vertex[2], culled[face])


def with_room(count: int) -> int:
    """A length for `count` rows and up to an eighth more, the same for most counts that are nearly the same."""
    step = 1 << max(count.bit_length() - 4, 0)
    return -(-count // step) * step


def _with_zeros(values: wp.array, length: int, device: wp.Device) -> wp.array:
    """Values of the CPU, and zeros after them up to a length, in an array of a device."""
    whole = wp.zeros(length, dtype=values.dtype, device=device)
    wp.copy(whole, values)
    return whole


def _wide(mesh: wp.Mesh, triangles: int) -> tuple[WideTree, Ints]:
    """The tree of four children a node of a mesh, and its levels. Raises RuntimeError if those are too many."""

    def made(tree: BinaryTree, *, improves: bool) -> tuple[WideTree, Ints]:
        if improves:
            reinsert(tree, ordered(tree))
        return collapsed(tree, ordered(tree), triangles)

    # Rows of ever smaller things are found soonest in chains, which may be longer than a stack.
    for improves in (True, False):
        wide, levels = DEVICE_SHARING.beside(partial(made, binary_tree(mesh, triangles), improves=improves))
        if len(levels) - 1 <= MAX_LEVELS:
            return wide, levels
    raise RuntimeError(f"the tree over {triangles} triangles has more than {MAX_LEVELS} levels")


def build(vertices: wp.array, indices: wp.array, culled: wp.array) -> Bvh:
    """A tree over one triangle or more, of `vertices` (vertex,) with corners `indices` (3·triangle,).

    There is room for some more nodes, so that one over what has moved a little mostly has arrays of the same sizes.

    culled (triangle,): 1 where the back can be culled, else 0.
    Raises RuntimeError if it has more levels than a ray's stack is made for.
    """
    device, triangles = vertices.device, len(indices) // 3
    constructor = "cubql" if device.is_cuda else "sah"
    make = partial(wp.Mesh, vertices, indices, bvh_constructor=constructor, bvh_leaf_size=LEAF_TRIANGLES)
    mesh = make() if device.is_cuda else DEVICE_SHARING.beside(make)
    wide, levels = _wide(mesh, triangles)
    bvh = Bvh()
    room = with_room(int(levels[-1]))
    bvh.bounds, bvh.children = _with_zeros(wide.bounds, 6 * room, device), _with_zeros(wide.children, 2 * room, device)
    # As long for every tree, so that one can take the place of another.
    bvh.levels = wp.array(np.pad(levels, (0, MAX_LEVELS + 1 - len(levels)), mode="edge"), dtype=int, device=device)
    bvh.faces = wp.empty(triangles, dtype=int, device=device)
    bvh.corners = wp.empty(len(indices), dtype=wp.vec4, device=device)
    places = wide.places.to(device)
    inputs = [mesh.id, places, vertices, indices, culled, bvh.corners, bvh.faces]
    launch(bvh_corner_kernel, len(bvh.faces), inputs, device)
    # What is read above goes with the mesh.
    wp.synchronize_device(device)
    return bvh
