import numpy as np
import pytest
from scenes import grey, quad, scene_of

from gpu.device_scene.extents import BLOCK, extents_of, renewed, solid_vertices
from gpu.scene.types import Material


@pytest.mark.parametrize(("begin", "end"), [(0, 0), (5, 6), (BLOCK - 1, 2 * BLOCK + 1), (2 * BLOCK, 2 * BLOCK + 7)])
def test_blocks_are_looked_at_where_vertices_have_moved(begin: int, end: int) -> None:
    rng = np.random.default_rng(1)
    vertices, solid = rng.normal(size=(2 * BLOCK + 7, 3)).astype(np.float32), rng.random(2 * BLOCK + 7) < 0.9
    for mask in (None, solid):
        found = extents_of(vertices, mask)
        now = vertices.copy()
        now[begin:end] *= 0.1
        kept = found.copy()
        assert np.array_equal(renewed(found, now, mask, begin, end), extents_of(now, mask))
        assert np.array_equal(found, kept)
    assert np.array_equal(extents_of(vertices, None).max(axis=0), np.abs(vertices).max(axis=0))


def test_a_backdrop_is_not_solid() -> None:
    quads = [quad([0, 0, 0], [1, 0, 0], [0, 1, 0], material) for material in (0, 1)]
    scene = scene_of(quads, [grey(0.5), Material(backdrop=True)])
    solid = solid_vertices(scene)
    assert solid is not None
    assert solid.tolist() == [number in scene.triangles[:2] for number in range(len(scene.vertices))]
    assert solid_vertices(scene_of(quads, [grey(0.5), grey(0.5)])) is None
