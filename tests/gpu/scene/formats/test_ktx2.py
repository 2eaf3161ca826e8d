import sys

import numpy as np
import pytest
from ktx2_file import ktx2, uastc_block

from gpu.errors import SceneError
from gpu.scene.formats.ktx2 import IDENTIFIER, decode_ktx2
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits

pytest.importorskip("opengl_basisu")

RED, GREEN, BLUE, CLEAR = (uastc_block(*color) for color in ((255, 0, 0), (0, 255, 0), (0, 0, 255), (9, 8, 7, 64)))
FILE = ktx2([[RED, GREEN], [BLUE, CLEAR]], 8, 6)


def test_pixels_from_the_top() -> None:
    pixels = decode_ktx2(FILE, "a.glb", "images[0]", DEFAULT_LIMITS)
    assert pixels.shape == (6, 8, 4)
    assert pixels.dtype == np.uint8
    colors = [pixels[0, 0], pixels[0, 7], pixels[5, 0], pixels[5, 7]]
    assert np.array_equal(colors, [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 8, 7, 64]])


@pytest.mark.parametrize("content", [IDENTIFIER, FILE[:90], FILE[:-1], IDENTIFIER + bytes(200)])
def test_broken_files(content: bytes) -> None:
    with pytest.raises(SceneError, match=r"a\.glb: images\[0\]: not a KTX 2 image that can be read"):
        decode_ktx2(content, "a.glb", "images[0]", DEFAULT_LIMITS)


@pytest.mark.parametrize("limits", [SceneLimits(max_texture_size=7), SceneLimits(max_texture_pixels=47)])
def test_large_files(limits: SceneLimits) -> None:
    with pytest.raises(SceneError, match="more than"):
        decode_ktx2(FILE, "a.glb", "images[0]", limits)


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    with pytest.raises(SceneError, match=r"needs the extra ktx2: pip install lumenwalk\[ktx2\]"):
        decode_ktx2(FILE, "a.glb", "images[0]", DEFAULT_LIMITS)
