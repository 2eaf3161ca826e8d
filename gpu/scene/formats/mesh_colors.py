"""Colours of vertices and faces as files of bare meshes have them: encoded as sRGB, as displays show them."""

from dataclasses import replace

import numpy as np

from gpu.scene.colors import srgb_to_linear
from gpu.scene.formats.mtl import DEFAULT_MATERIAL
from gpu.scene.remarks import Remarks
from gpu.scene.types import AlphaMode, Doubles, Floats, Material


def linear_colors(values: Doubles, remarks: Remarks, full: float | None = None) -> Doubles:
    """Linear RGBA (row, 4) of sRGB-encoded `values` (row, 3 or 4), of which `full` is white, or 0–1 or 0–255.

    A colour that is not finite becomes white, and said.
    """
    broken = np.any(~np.isfinite(values), axis=1)
    remarks.add_count("colours that are not finite numbers were taken as white", int(broken.sum()))
    sound = values[~broken]
    white = full if full is not None else 255.0 if sound.size and sound.max() > 1.0 else 1.0
    colors = np.ones((len(values), 4))
    colors[~broken, : values.shape[1]] = np.clip(sound / white, 0.0, 1.0)
    if not colors[~broken, 3].any():
        remarks.add("alpha is 0 everywhere in the colours and was ignored")
        colors[:, 3] = 1.0
    colors[:, :3] = srgb_to_linear(colors[:, :3] * 255.0)
    return colors


def bare_material(colors: Doubles | Floats | None) -> Material:
    """The material of a mesh without any: matt grey, or as its `colors` (row, 4) are, with their alpha."""
    if colors is None:
        return DEFAULT_MATERIAL
    blend = bool((colors[:, 3] < 1.0).any())
    mode = AlphaMode.BLEND if blend else AlphaMode.OPAQUE
    return replace(DEFAULT_MATERIAL, base_color=(1.0, 1.0, 1.0, 1.0), alpha_mode=mode)
