"""Trees over a scene's triangles, which leave out those that lie in the place of others."""

import warp as wp

from gpu.core.device import launch
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_build import build
from gpu.device_scene.data import SceneData
from gpu.device_scene.repeated import distinct


@wp.kernel
def listed_corners_kernel(first: int, triangles: wp.array[wp.vec3i], culled: wp.array[float], begin: int,
                          listed: wp.array[int], indices: wp.array[int],
                          listed_culled: wp.array[float]) -> None:  # fmt: skip
    """One thread a `listed` triangle, numbered from `begin`: its corners, indices (3·place,), and whether it is culled.

    triangles, culled (triangle,): of all; listed_culled (place,): of these.
    """
    place = first + wp.tid()
    triangle = begin + listed[place]
    for corner in range(3):
        indices[3 * place + corner] = triangles[triangle][corner]
    listed_culled[place] = culled[triangle]


@wp.kernel
def number_faces_kernel(first: int, listed: wp.array[int], faces: wp.array[int]) -> None:
    """One thread a leaf's triangle, faces (place,), which is a number of those listed: what is listed there."""
    place = first + wp.tid()
    faces[place] = listed[faces[place]]


def tree_over(scene: SceneData, culled: wp.array, begin: int, end: int, *, looks: bool = False) -> Bvh:
    """A tree over the triangles from `begin` to `end` but repeated ones, numbered from `begin`.

    culled (triangle,): 1 where the back can be culled, else 0; looks: triangles that look different, as where alpha
    cuts holes, are different.
    """
    device = scene.vertices.device
    listed, _ = distinct(scene, begin, end, looks=looks)
    indices = wp.empty(3 * len(listed), dtype=int, device=device)
    own = wp.empty(len(listed), dtype=float, device=device)
    launch(listed_corners_kernel, len(listed), [scene.triangles, culled, begin, listed, indices, own], device)
    tree = build(scene.vertices, indices, own)
    if len(listed) < end - begin:
        launch(number_faces_kernel, len(listed), [listed, tree.faces], device)
    return tree
