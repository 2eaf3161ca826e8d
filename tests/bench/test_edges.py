from pathlib import Path

import numpy as np
from PIL import Image

from tests.bench.edges import save_pictures


def test_pictures_lie_side_by_side(tmp_path: Path) -> None:
    dark, light = np.zeros((4, 5, 3), np.float32), np.full((4, 5, 3), 2.0, np.float32)
    save_pictures(tmp_path / "new" / "room.png", [dark, light, light / 6.0])
    pixels = np.asarray(Image.open(tmp_path / "new" / "room.png"))
    assert pixels.shape == (4, 15, 3)
    assert [int(pixels[0, column, 0]) for column in (0, 5, 10)] == [0, 255, 156]
