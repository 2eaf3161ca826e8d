"""The binary tree that Warp builds for a mesh, on the host."""

import warp as wp

from gpu.core.device import launch, launch_on_host
from gpu.core.kernel_loading import host_kernel

NO_NODE = wp.constant(-1)


@wp.struct
class BinaryTree:
    """Nodes of a binary tree, in arrays of the CPU.

    lower, upper (node,): their boxes; left, right (node,): their children or, where `is_leaf` is 1, the first place of
    their triangles and the one after the last; parent (node,): NO_NODE for the root.
    """

    root: int
    lower: wp.array[wp.vec3]
    upper: wp.array[wp.vec3]
    left: wp.array[int]
    right: wp.array[int]
    is_leaf: wp.array[int]
    parent: wp.array[int]


@wp.func_native("return *wp::mesh_get(mesh).bvh.root;")
def root_of(mesh: wp.uint64) -> wp.int32:
    """The root of a mesh's binary tree."""


@wp.func_native("return wp::mesh_get(mesh).bvh.num_nodes;")
def node_count_of(mesh: wp.uint64) -> wp.int32:
    """How many nodes a mesh's binary tree has, of which some may be of no use."""


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


@wp.kernel
def read_nodes_kernel(first: int, mesh: wp.uint64, root: wp.array[int], lower: wp.array[wp.vec3],
                      upper: wp.array[wp.vec3], entries: wp.array[wp.vec3i]) -> None:  # fmt: skip
    """One thread a node that a mesh's tree may have: its box and `entry_of`, (node,) each; root (1,)."""
    node = first + wp.tid()
    if node == 0:
        root[0] = root_of(mesh)
    if node < node_count_of(mesh):
        lower[node] = lower_of(mesh, node)
        upper[node] = upper_of(mesh, node)
        entries[node] = entry_of(mesh, node)


@host_kernel
def name_parents_kernel(tree: BinaryTree, order: wp.array[int]) -> None:
    """Each node's parent, and the nodes in use so that each comes after its parent.

    order (node,): NO_NODE after the last one.
    """
    tree.parent[tree.root] = NO_NODE
    order[0] = tree.root
    count = int(1)
    place = int(0)
    while place < count:
        node = order[place]
        if tree.is_leaf[node] == 0:
            for side in range(2):
                child = wp.where(side == 0, tree.left[node], tree.right[node])
                tree.parent[child] = node
                order[count] = child
                count += 1
        place += 1


@wp.func
def half_area(lower: wp.vec3, upper: wp.vec3) -> float:
    """Half the surface of a box."""
    size = upper - lower
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0]


@wp.func
def area_of(tree: BinaryTree, node: int) -> float:
    """Half the surface of a node's box."""
    return half_area(tree.lower[node], tree.upper[node])


def binary_tree(mesh: wp.Mesh, triangles: int) -> BinaryTree:
    """The tree of a mesh of so many triangles, in arrays of the CPU."""
    device, nodes = mesh.device, 2 * triangles - 1
    lower, upper = (wp.zeros(nodes, dtype=wp.vec3, device=device) for _ in range(2))
    entries, root = wp.zeros(nodes, dtype=wp.vec3i, device=device), wp.zeros(1, dtype=int, device=device)
    launch(read_nodes_kernel, nodes, [mesh.id, root, lower, upper, entries], device)
    tree, host = BinaryTree(), wp.get_device("cpu")
    tree.root = int(root.numpy()[0])
    tree.lower, tree.upper = lower.to(host), upper.to(host)
    columns = entries.numpy().T
    tree.is_leaf, tree.left, tree.right = (wp.array(column, dtype=int, device=host) for column in columns)
    tree.parent = wp.full(nodes, NO_NODE, dtype=int, device=host)
    return tree


def ordered(tree: BinaryTree) -> wp.array:
    """The nodes of a tree, each after its parent, which each is told."""
    order = wp.full(len(tree.parent), NO_NODE, dtype=int, device=tree.parent.device)
    launch_on_host(name_parents_kernel, [tree, order])
    return order[: int((order.numpy() != NO_NODE).sum())]
