"""Hierarchies whose nodes may be used many times, as files of instances have them."""

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Doubles
from gpu.scene.validate import check_count

Node = TypeVar("Node", bound=Hashable)
Leaf = TypeVar("Leaf")
Contents = tuple[list[tuple[Doubles, Leaf]], list[tuple[Doubles, Node]]]
"""What a node holds: leaves, and further nodes, each with its 4×4 matrix."""


class Hierarchy(Generic[Node, Leaf]):
    """What each node holds, in itself and through others: found once, however often the node is used.

    contents: what a node holds in itself; name: what an error calls it.
    """

    def __init__(
        self,
        source: str,
        limits: SceneLimits,
        contents: Callable[[Node], Contents[Leaf, Node]],
        name: Callable[[Node], str],
    ) -> None:
        self._source, self._limit, self._contents, self._name = source, limits.max_triangles, contents, name
        self._known: dict[Node, list[tuple[Doubles, Leaf]]] = {}
        self._open: set[Node] = set()

    def leaves(self, node: Node) -> list[tuple[Doubles, Leaf]]:
        """All leaves in `node` with their matrices. Raises SceneError when it contains itself, or too many."""
        try:
            return self._leaves(node)
        except RecursionError as error:
            raise SceneError(self._source, self._name(node), "what it contains is nested too deep") from error

    def _leaves(self, node: Node) -> list[tuple[Doubles, Leaf]]:
        if node in self._open:
            raise SceneError(self._source, self._name(node), "it contains itself")
        if node not in self._known:
            self._open.add(node)
            leaves, inner = self._contents(node)
            found = list(leaves)
            for matrix, child in inner:
                found += [(matrix @ own, leaf) for own, leaf in self._leaves(child)]
                check_count(self._source, "instances", len(found), self._limit, "max_triangles")
            self._open.remove(node)
            self._known[node] = found
        return self._known[node]
