"""Fits a tree (gpu.device_scene.bvh) to where its triangles are now: its nodes stay, their boxes follow.

That takes a hundredth of the time of a new tree. Rays look at more boxes the farther things have moved, and meet what
they would in any other tree.
"""

from collections.abc import Sequence
from itertools import pairwise

import warp as wp

from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.device_scene.binary_tree import NO_NODE
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_collapse import WIDTH


@wp.kernel
def bvh_move_corners_kernel(first: int, bvh: Bvh, vertices: wp.array[wp.vec3], triangles: wp.array[wp.vec3i],
                            begin: int) -> None:  # fmt: skip
    """One thread a place of the leaves: the corners of its triangle. vertices, triangles, begin: as of `refit`."""
    place = first + wp.tid()
    corner = triangles[begin + bvh.faces[place]]
    for k in range(3):
        vertex = vertices[corner[k]]
        bvh.corners[3 * place + k] = wp.vec4(vertex[0], vertex[1], vertex[2], bvh.corners[3 * place + k][3])


@wp.kernel
def bvh_refit_kernel(first: int, bvh: Bvh, begin: int) -> None:
    """One thread a node from `begin` on, of which those of later levels are fitted: the boxes of its children."""
    node = begin + first + wp.tid()
    for slot in range(WIDTH):
        child = bvh.children[2 * node][slot]
        count = bvh.children[2 * node + 1][slot]
        if child == NO_NODE:
            continue
        lower = wp.vec3(FAR_AWAY, FAR_AWAY, FAR_AWAY)
        upper = -lower
        if count > 0:
            for place in range(3 * child, 3 * (child + count)):
                corner = bvh.corners[place]
                point = wp.vec3(corner[0], corner[1], corner[2])
                lower = wp.min(lower, point)
                upper = wp.max(upper, point)
        else:
            for inner in range(WIDTH):
                if bvh.children[2 * child][inner] != NO_NODE:
                    for axis in range(3):
                        lower[axis] = wp.min(lower[axis], bvh.bounds[6 * child + 2 * axis][inner])
                        upper[axis] = wp.max(upper[axis], bvh.bounds[6 * child + 2 * axis + 1][inner])
        for axis in range(3):
            bvh.bounds[6 * node + 2 * axis][slot] = lower[axis]
            bvh.bounds[6 * node + 2 * axis + 1][slot] = upper[axis]


def copied(bvh: Bvh) -> Bvh:
    """The same tree in arrays of its own."""
    tree = Bvh()
    for name in ("bounds", "children", "corners", "faces", "levels"):
        setattr(tree, name, wp.clone(getattr(bvh, name)))
    return tree


def refit(bvh: Bvh, levels: Sequence[int], vertices: wp.array, triangles: wp.array, begin: int) -> None:
    """Have a tree, whose `levels` the host knows, follow its triangles to where these are now.

    vertices (vertex,); triangles (triangle,): their corners, those of the tree from `begin` on.
    """
    launch(bvh_move_corners_kernel, len(bvh.faces), [bvh, vertices, triangles, begin], vertices.device)
    for start, end in pairwise(levels[::-1]):
        launch(bvh_refit_kernel, start - end, [bvh, end], vertices.device)
