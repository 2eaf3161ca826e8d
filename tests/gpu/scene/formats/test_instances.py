import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.instances import Contents, Hierarchy
from gpu.scene.limits import SceneLimits


def moved(x: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[0, 3] = x
    return matrix


def hierarchy(children: dict[str, list[str]], limit: int = 100) -> Hierarchy[str, str]:
    """Each node is moved by 1; one in lower case is a leaf as well."""

    def contents(node: str) -> Contents[str, str]:
        leaves = [(moved(1.0), node)] if node.islower() else []
        return leaves, [(moved(1.0), child) for child in children.get(node, [])]

    return Hierarchy("a.x", SceneLimits(max_triangles=limit), contents, lambda node: f"node {node}")


def test_a_node_is_found_as_often_as_it_is_used() -> None:
    found = hierarchy({"A": ["B", "c", "B"], "B": ["c"]}).leaves("A")
    assert [(matrix[0, 3], leaf) for matrix, leaf in found] == [(3.0, "c"), (2.0, "c"), (3.0, "c")]


@pytest.mark.parametrize("children", [{"A": ["A"]}, {"A": ["B"], "B": ["c"], "c": ["A"]}])
def test_a_node_that_contains_itself_is_refused(children: dict[str, list[str]]) -> None:
    with pytest.raises(SceneError, match=r"a\.x: node A: it contains itself"):
        hierarchy(children).leaves("A")


def test_nodes_that_multiply_are_refused() -> None:
    doubling = {f"N{n}": [f"N{n + 1}"] * 2 for n in range(60)} | {"N60": ["leaf"]}
    with pytest.raises(SceneError, match="128 instances, more than the 100 allowed"):
        hierarchy(doubling).leaves("N0")
    assert hierarchy(doubling | {"N60": []}).leaves("N0") == []


def test_nodes_nested_too_deep_are_refused() -> None:
    with pytest.raises(SceneError, match="nested too deep"):
        hierarchy({f"N{n}": [f"N{n + 1}"] for n in range(5000)}).leaves("N0")
