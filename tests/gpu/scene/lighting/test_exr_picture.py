from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from gpu.errors import ImageError
from gpu.scene.lighting.exr_picture import read_exr, to_rec_709

ACES_CG = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
PICTURE = np.random.default_rng(0).random((2, 4, 3)).astype(np.float32)


def written(folder: Path, names: str, **header: Any) -> Path:
    """A picture whose channels, of these names, are red, green, blue and red again."""
    path = folder / "a.exr"
    channels = {name: np.ascontiguousarray(PICTURE[..., at % 3]) for at, name in enumerate(names.split())}
    head = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(head | header, channels).write(str(path))
    return path


@pytest.mark.parametrize(
    "names", ["R G B A", "view.Combined.R view.Combined.G view.Combined.B view.Depth.Z", "R G B b.R"]
)
def test_colours_are_those_of_the_only_layer_that_has_some_or_of_none(tmp_path: Path, names: str) -> None:
    assert np.array_equal(read_exr(written(tmp_path, names), 8), PICTURE)


@pytest.mark.parametrize("names", ["X Y Z", "BY RY Y", "a.R a.G a.B b.R b.G b.B", "r g b"])
def test_other_colours_are_refused_with_the_channels_that_there_are(tmp_path: Path, names: str) -> None:
    there = ", ".join(sorted(names.split()))
    with pytest.raises(ImageError, match=f"no readable channels R, G and B of one picture; it has {there}"):
        read_exr(written(tmp_path, names), 8)


def test_too_many_pixels_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="has 4 x 2 pixels; at most 7 are read"):
        read_exr(written(tmp_path, "R G B"), 7)


def test_colours_of_other_primaries_are_converted(tmp_path: Path) -> None:
    pixels = read_exr(written(tmp_path, "R G B", chromaticities=ACES_CG), 8)
    # Of the Academy's ACEScg to linear Rec. 709, by Bradford's adaptation.
    red, green, blue = (1.70505, -0.62179, -0.08326), (-0.13026, 1.14080, -0.01055), (-0.02400, -0.12897, 1.15297)
    assert np.allclose(pixels, PICTURE @ np.array([red, green, blue]).T, atol=1e-3)
    assert np.allclose(to_rec_709(np.array(ACES_CG)) @ [1.0, 1.0, 1.0], 1.0)


def test_primaries_that_are_none_change_nothing(tmp_path: Path) -> None:
    assert np.array_equal(read_exr(written(tmp_path, "R G B", chromaticities=(0.0,) * 8), 8), PICTURE)
    assert np.array_equal(to_rec_709(np.zeros(8)), np.eye(3))
