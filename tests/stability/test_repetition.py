"""The same seed gives the same bits, every time anew: scene, acceleration structure, lights, clusters and picture."""

import numpy as np
import pytest
from scenes import box, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import AlphaMode, Light, LightKind, Material, Scene, Sky, Texture, TextureSlot
from gpu.settings import Method, RenderSettings, Skips

TIMES = 8
SIZE = (40, 30)
CAMERA = look_at((0.0, 0.1, 0.4), (0.0, -0.1, -0.5), yfov_degrees=75.0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Something of everything: soft and hard lights, a sky through a window, a mask, gloss, faces that coincide."""
    rng = np.random.default_rng(0)
    mask = Texture("mask", rng.integers(0, 256, (8, 8, 4), np.uint8), srgb=True)
    glossy = Material(base_color=(0.8, 0.5, 0.3, 1.0), roughness=0.3)
    masked = Material(alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    parts = box()[1:]
    # With the sky two lights to choose from, for which kernels are compiled anyway.
    corners = np.array([(-0.2, 0.45, -0.2), (0.2, 0.45, -0.2), (0.2, 0.45, 0.2)])
    parts.append(MeshPart(corners, np.array([[0, 1, 2]]), material=1))
    parts += [quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.4), (0.4, 0.0, 0.0), 0)] * 2
    parts.append(quad((0.1, -0.5, -0.2), (0.3, 0.0, 0.1), (0.0, 0.6, 0.0), 2))
    bulb = Light("bulb", LightKind.POINT, (0.2, 0.3, 0.1), position=(0.3, 0.2, 0.2))
    lamp = Material(emission=(3.0, 2.0, 1.0))
    return scene_of(parts, [glossy, lamp, masked], [bulb], Sky((0.3, 0.4, 0.5)), [mask])


@pytest.mark.parametrize("method", list(Method))
def test_the_same_seed_gives_the_same_bits(device: str, scene: Scene, method: Method) -> None:
    counts = {"samples": 2, "sp_clusters": 150, "vpls": 1000, "vpl_clusters": 80}
    settings = RenderSettings(method=method, **counts, seed=5, skip=Skips(unchanged_camera=False))
    pictures = set()
    for _ in range(TIMES):
        renderer = Renderer(DeviceScene(scene, device).generalised(), SIZE, settings)
        # On CUDA a stage's second run is captured as a graph, and the third replays it.
        for _ in range(3 if device != "cpu" and method is Method.FUZZY_VPL else 1):
            frame = renderer.render(CAMERA)
            pictures.add((frame.radiance().tobytes(), frame.pixels().tobytes()))
        assert frame.stats.counts["nonfinite"] == 0
    assert len(pictures) == 1
    radiance = np.frombuffer(pictures.pop()[0], np.float32)
    assert (radiance > 0.0).mean() > 0.9
