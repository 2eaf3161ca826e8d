"""Colours of bare meshes: ranges, encoding, alpha, and the material they make."""

import numpy as np
import pytest

from gpu.scene.formats.mesh_colors import bare_material, linear_colors
from gpu.scene.formats.mtl import DEFAULT_MATERIAL
from gpu.scene.remarks import Remarks
from gpu.scene.types import AlphaMode


@pytest.mark.parametrize(
    ("values", "full"), [([1, 0.5, 0], None), ([255, 127.5, 0], None), ([65535, 32767.5, 0], 65535)]
)
def test_colours_are_encoded_whatever_white_is(values: list[float], full: float | None) -> None:
    assert linear_colors(np.array([values]), Remarks(), full) == pytest.approx(np.array([[1, 0.2140, 0, 1]]), abs=1e-4)


def test_broken_colours_are_white_and_alpha_that_hides_all_is_ignored() -> None:
    remarks = Remarks()
    colors = linear_colors(np.array([[0.0, 0, 0, 0], [1, np.nan, 0, 0], [1, 0, 0, 0]]), remarks)
    assert colors.tolist() == [[0, 0, 0, 1], [1, 1, 1, 1], [1, 0, 0, 1]]
    assert len(remarks.sentences()) == 2


def test_the_material_is_grey_or_as_the_colours_are() -> None:
    assert bare_material(None) is DEFAULT_MATERIAL
    assert bare_material(np.ones((2, 4))).alpha_mode is AlphaMode.OPAQUE
    glass = bare_material(np.array([[1, 1, 1, 0.5]]))
    assert (glass.base_color, glass.alpha_mode) == ((1, 1, 1, 1), AlphaMode.BLEND)
