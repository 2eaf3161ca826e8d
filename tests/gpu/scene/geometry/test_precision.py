import numpy as np
import pytest

from gpu.scene.geometry.bulk import bulk_of
from gpu.scene.geometry.precision import device_precision, file_precision
from tests.gpu.rooms import room


@pytest.mark.parametrize(("away", "words"), [(0.0, []), (1e3, []), (4.6e5, ["rounded to 3.1 cm"])])
def test_a_file_that_lost_digits_is_named(away: float, words: list[str]) -> None:
    positions, triangles = room(4.1, 4.2, 3.3)
    written = (np.add(positions, (away, 0.0, 0.0))).astype(np.float32).astype(np.float64)
    said = file_precision(written, bulk_of(written, triangles), 1.0)
    assert len(said) == len(words)
    assert all(word in sentence for word, sentence in zip(words, said, strict=True))


def test_what_is_far_from_the_scene_says_nothing_of_its_precision() -> None:
    positions, triangles = room(4.1, 4.2, 3.3)
    written = np.vstack([positions, np.add(positions[:3], (4.6e5, 0.0, 0.0))]).astype(np.float32).astype(np.float64)
    stray = np.vstack([triangles, np.arange(3)[None] + len(positions)])
    assert file_precision(written, bulk_of(written, stray), 1.0) == []


def test_doubles_lose_nothing() -> None:
    positions, triangles = room(4.1, 4.2, 3.3)
    exact = positions + 460_000.123
    assert file_precision(exact, bulk_of(exact, triangles), 1.0) == []


def test_a_scene_of_few_large_triangles_has_no_leaks_to_name() -> None:
    """Their middles are near the scene's own, however large they are."""
    corners = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0]], np.float32)
    assert device_precision(corners, np.array([[0, 1, 2]]), 1.0) == []


@pytest.mark.parametrize(("extent", "said"), [(40.0, False), (4e3, False), (4e5, True)])
def test_a_house_on_a_vast_plain_has_leaks_that_are_named(extent: float, said: bool) -> None:
    positions, triangles = room(4.0, 4.0, 3.0)
    plain = np.array([[-0.5, 0, -0.5], [0.5, 0, -0.5], [0.5, 0, 0.5]])
    vertices = np.vstack([positions / extent + 0.3, plain]).astype(np.float32)
    sentences = device_precision(vertices, np.vstack([triangles, [[8, 9, 10]]]), extent)
    assert len(sentences) == said
    assert all("400 km" in sentence for sentence in sentences)
