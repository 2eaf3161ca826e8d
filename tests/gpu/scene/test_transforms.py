import numpy as np
import pytest

from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import AT_ONCE, cofactors, mirrored, placed, placed_each, rigid, slot_transform


def test_cofactors_keep_normals_on_their_side() -> None:
    matrices = np.stack([np.diag(scale) for scale in ([2.0, 1, 1, 1], [-1.0, 1, 1, 1], [1.0, 1, 0, 1])])
    turned = np.einsum("nij,j->ni", cofactors(matrices), [1.0, 1.0, 0.0])
    assert np.array_equal(mirrored(matrices), [False, True, False])
    assert np.allclose(turned[0] / turned[0, 1], [0.5, 1, 0])  # as the inverse transpose
    assert turned[1, 0] < 0.0 < turned[1, 1]  # mirrored like the surface
    assert np.isfinite(turned[2]).all()


@pytest.mark.parametrize(
    "matrix", [np.diag([2.0, 3.0, 4.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0]), np.diag([0.0, 0.0, 0.0, 1.0])]
)
def test_rigid_removes_scale_and_mirroring(matrix: np.ndarray) -> None:
    matrix[:3, 3] = (1, 2, 3)
    axes = rigid(matrix)[:3, :3]
    assert np.allclose(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) > 0.0
    assert np.allclose(axes[:, 2], (0, 0, 1))
    assert np.array_equal(rigid(matrix)[:3, 3], (1, 2, 3))


def test_a_part_placed_twice() -> None:
    part = MeshPart(np.eye(3), np.array([[0, 1, 2]]), np.tile([0.0, 0.0, 1.0], (3, 1)), (np.ones((3, 2)),))
    matrices = np.stack([np.eye(4), np.diag([-1.0, 1.0, 1.0, 1.0])])
    matrices[1, :3, 3] = (5, 0, 0)
    twice = placed(part, matrices)
    assert np.array_equal(twice.triangles, [[0, 1, 2], [5, 4, 3]])  # the mirrored one is wound the other way
    assert np.array_equal(twice.positions[3:], [[4, 0, 0], [5, 1, 0], [5, 0, 1]])
    assert np.allclose(twice.normals, (0, 0, 1))
    assert [len(uv) for uv in twice.uvs] == [6]


def test_instances_that_have_names_are_objects_of_their_own() -> None:
    part = MeshPart(np.eye(3), np.array([[0, 1, 2]]), name="chair")
    matrices = np.stack([np.eye(4)] * 2)
    assert placed(part, matrices).owners[0] == ("chair",)
    names, own = placed(part, matrices, ["left", "right"]).owners
    assert names == ("left", "right")
    assert own.tolist() == [0, 0, 0, 1, 1, 1]


def test_parts_placed_each_by_its_own_matrix_are_as_placed_alone() -> None:
    dice = np.random.default_rng(1)
    sizes = [3, AT_ONCE - 3, 4, 5]
    matrices = dice.normal(size=(len(sizes), 4, 4))
    matrices[:, 3] = (0, 0, 0, 1)
    triangles = np.array([[0, 1, 2]])
    parts = [MeshPart(dice.normal(size=(n, 3)), triangles, dice.normal(size=(n, 3)) if n != 4 else None) for n in sizes]
    assert len(set(mirrored(matrices).tolist())) == 2
    for part, matrix, found in zip(parts, matrices, placed_each(parts, matrices), strict=True):
        alone = placed(part, matrix[None])
        assert np.array_equal(found.positions, alone.positions)
        assert np.array_equal(found.triangles, alone.triangles)
        assert (found.normals is None) == (alone.normals is None)
        assert found.normals is None or np.array_equal(found.normals, alone.normals)


def test_a_transform_of_a_texture_is_of_v_from_the_top() -> None:
    a, b, c, d, e, f = slot_transform(np.array([[2.0, 0.5, 0.1], [0.25, 3.0, 0.2], [0.0, 0.0, 1.0]]))
    u, v = 0.3, 0.9
    from_bottom = 2.0 * u + 0.5 * (1.0 - v) + 0.1, 0.25 * u + 3.0 * (1.0 - v) + 0.2
    assert (a * u + b * v + c, 1.0 - (d * u + e * v + f)) == pytest.approx(from_bottom)
