"""Renders of the stress tests: every frame is checked for what no frame may have."""

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.types import Camera, Floats
from gpu.settings import RenderSettings

# Enough for the small scenes here.
COUNTS = {"sp_clusters": 200, "vpls": 1000, "vpl_clusters": 60, "photons": 4000}


def render(device_scene: DeviceScene, camera: Camera, size: tuple[int, int], **settings: object) -> Floats:
    """Linear radiance (height, width, 3) of a frame, of which nothing is non-finite or negative and all is served."""
    frame = Renderer(device_scene, size, RenderSettings(**{**COUNTS, **settings})).render(camera)
    radiance = frame.radiance()
    assert np.isfinite(radiance).all()
    assert (radiance >= 0.0).all()
    assert frame.stats.counts["nonfinite"] == 0
    assert frame.stats.counts.get("unassigned", 0) == 0
    return radiance
