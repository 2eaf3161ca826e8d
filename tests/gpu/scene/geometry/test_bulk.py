import numpy as np
import pytest

from gpu.scene.geometry.bulk import FARTHEST, bulk_of
from gpu.scene.types import Doubles, Integers
from tests.gpu.rooms import room

MARKER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1]])


def with_far(distance: float, far: Doubles = MARKER) -> tuple[Doubles, Integers]:
    """A room of 4 × 4 × 3, and triangles of `far` at that distance."""
    positions, triangles = room(4.0, 4.0, 3.0)
    more = np.arange(len(far)).reshape(-1, 3) + len(positions)
    return np.vstack([positions, np.add(far, (distance, 0.0, 0.0))]), np.vstack([triangles, more])


@pytest.mark.parametrize("distance", [1e2, 2e3, 1e4, 3e4, 4.6e5, 1e6, 1e9])
def test_what_is_small_and_far_away_does_not_count(distance: float) -> None:
    bulk = bulk_of(*with_far(distance))
    assert bulk.member.tolist() == [True] * 12 + [False]
    assert (bulk.low.tolist(), bulk.high.tolist()) == ([0.0, 0.0, 0.0], [4.0, 3.0, 4.0])
    assert bulk.too_far.tolist() == [False] * 12 + [distance > FARTHEST * 4.0]
    assert bulk.distances[-1] == pytest.approx(distance, rel=0.03)


def test_a_room_far_from_zero_is_found_as_well() -> None:
    positions, triangles = with_far(4.6e5)
    bulk = bulk_of(positions - (4.6e5, 0.0, 5e4), triangles)
    assert bulk.member.sum() == 12


def test_what_lies_around_belongs_to_it() -> None:
    """Trees in a garden, houses in a street: each no farther than a few times what lies nearer."""
    near = np.concatenate([np.add(MARKER, (2.5**step, 0.0, 0.0)) for step in range(1, 8)])
    assert bulk_of(*with_far(0.0, near)).member.all()


@pytest.mark.parametrize("size", [50.0, 1e4, 1e6], ids=str)
def test_a_ground_plane_is_large_not_far(size: float) -> None:
    ground = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    bulk = bulk_of(*with_far(0.0, ground * size))
    assert bulk.member.all()
    assert np.ptp([bulk.low, bulk.high], axis=0)[0] == 2.0 * size


def test_a_second_building_is_no_small_thing() -> None:
    positions, triangles = room(4.0, 4.0, 3.0)
    both = np.vstack([positions, np.add(positions, (1e5, 0.0, 0.0))]), np.vstack([triangles, triangles + 8])
    assert bulk_of(*both).member.all()


def test_triangles_without_area_have_a_bulk_too() -> None:
    assert bulk_of(np.zeros((3, 3)), np.array([[0, 1, 2]])).member.all()
