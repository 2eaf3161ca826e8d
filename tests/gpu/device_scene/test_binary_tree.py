"""The binary tree that Warp builds, on the host."""

import pytest
from binary_trees import rods, tree_over

from gpu.core.kernel_loading import imported_kernels
from gpu.device_scene import binary_tree as subject
from gpu.device_scene.binary_tree import NO_NODE, ordered


@pytest.mark.parametrize("count", [1, 2, 5, 400])
def test_each_node_comes_after_its_parent(count: int) -> None:
    tree = tree_over(rods(count))
    nodes, parents = ordered(tree).numpy().tolist(), tree.parent.numpy()
    assert nodes[0] == tree.root
    assert parents[tree.root] == NO_NODE
    assert all(nodes.index(parents[node]) < place for place, node in enumerate(nodes[1:], 1))


def test_kernels_of_the_host_are_not_loaded_for_a_device() -> None:
    names = {kernel.key for kernel in imported_kernels()}
    assert subject.read_nodes_kernel.key in names
    assert subject.name_parents_kernel.key not in names
