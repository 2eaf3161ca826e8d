"""OpenEXR pictures: which channels are their colours, and these in the primaries of Rec. 709."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from gpu.errors import ImageError
from gpu.scene.colors import REC_709
from gpu.scene.types import Doubles, Floats

_CONES = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])  # Bradford
_SAME = 1e-3  # of coordinates that are written with few digits
_NAMED = 12  # of channels, where they are not those of colours


def read_exr(path: Path, max_pixels: int) -> Floats:
    """Linear radiance (height, width, 3), Rec. 709, of a picture of channels R, G and B, in a layer of their own or in
    none, or Y alone.

    Raises ImageError where it has others, more pixels, or cannot be read.
    """
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            header: dict[str, Any] = file.header()
            window, primaries = header["dataWindow"], header.get("chromaticities")
            channels = {name: channel.pixels for name, channel in file.channels().items()}
    except Exception as error:  # OpenEXR raises whatever it likes on broken files
        raise ImageError(f"{path}: is no OpenEXR picture that can be read") from error
    names = _colors(list(channels))
    if names is None or any(channels[name] is None for name in names):
        there = ", ".join([*channels][:_NAMED])
        raise ImageError(f"{path}: has no readable channels R, G and B of one picture; it has {there:.200}")
    width, height = (int(high) - int(low) + 1 for low, high in zip(*window, strict=True))
    if not 0 < height * width <= max_pixels:
        raise ImageError(f"{path}: has {width} x {height} pixels; at most {max_pixels:,} are read; make it smaller")
    pixels = np.stack([channels[name] for name in names], axis=-1).astype(np.float32)
    if primaries is None or names[0] == "Y" or np.allclose(primaries, REC_709, atol=_SAME):
        return pixels
    return np.asarray(pixels @ to_rec_709(np.array(primaries, np.float64)).T.astype(np.float32))


def _colors(names: list[str]) -> tuple[str, str, str] | None:
    """The channels that are red, green and blue; None where none are, or those of several layers."""
    layers = [name[:-1] for name in names if name.endswith("R") and {name[:-1] + it for it in "GB"} <= set(names)]
    if "" in layers or len(layers) == 1:
        layer = "" if "" in layers else layers[0]
        return f"{layer}R", f"{layer}G", f"{layer}B"
    alone = "Y" in names and not {"RY", "BY", "X", "Z"} & set(names)  # these hold its colours
    return ("Y", "Y", "Y") if alone else None


def to_rec_709(chromaticities: Doubles) -> Doubles:
    """The matrix (3, 3) from colours of primaries and a white (8,), x and y of each, to those of Rec. 709, whose white
    is D65; that of nothing where they are none.
    """
    to_xyz, white = _to_xyz(chromaticities)
    ours, our_white = _to_xyz(np.array(REC_709))
    with np.errstate(all="ignore"):
        adapted = np.linalg.inv(_CONES) @ np.diag((_CONES @ our_white) / (_CONES @ white)) @ _CONES
        matrix = np.linalg.inv(ours) @ adapted @ to_xyz
    return np.asarray(matrix if np.isfinite(matrix).all() else np.eye(3))


def _to_xyz(chromaticities: Doubles) -> tuple[Doubles, Doubles]:
    """The matrix (3, 3) from colours of primaries (8,) to CIE XYZ, where their white (3,) has Y = 1."""
    x, y = chromaticities.reshape(4, 2).T
    with np.errstate(all="ignore"):
        points = np.stack([x / y, np.ones(4), (1.0 - x - y) / y])
        try:
            strengths = np.linalg.solve(points[:, :3], points[:, 3])
        except np.linalg.LinAlgError:
            strengths = np.full(3, np.nan)
        return points[:, :3] * strengths, points[:, 3]
