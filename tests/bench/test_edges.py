from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.bench.edges import changes_at_rest, save_pictures


def test_pictures_lie_side_by_side(tmp_path: Path) -> None:
    dark, light = np.zeros((4, 5, 3), np.float32), np.full((4, 5, 3), 2.0, np.float32)
    save_pictures(tmp_path / "new" / "room.png", [dark, light, light / 6.0])
    pixels = np.asarray(Image.open(tmp_path / "new" / "room.png"))
    assert pixels.shape == (4, 15, 3)
    assert [int(pixels[0, column, 0]) for column in (0, 5, 10)] == [0, 255, 156]


def test_changes_at_rest_are_of_radiance_and_of_what_is_shown() -> None:
    rests = np.ones((16, 16, 3))
    rests[:2, :2] = 60.0
    last = rests.copy()
    last[:2, :2] = 50.0
    last[-2:, -2:] = 1.1
    changes = changes_at_rest(last, rests)
    assert changes["radiance"]["worst"] == pytest.approx(0.2)
    assert changes["radiance"]["median"] == changes["shown"]["median"] == 0.0
    assert 0.03 < changes["shown"]["worst"] < 0.06  # of the brightest, both are white
