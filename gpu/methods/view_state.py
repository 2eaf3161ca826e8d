"""One viewer's image: the arrays of its size, which live as long as its renderer, and the camera it looks through."""

from typing import Any

import warp as wp

from gpu.core.device import allocate
from gpu.core.staging import StagingBuffer
from gpu.correction.brightness import MeanBrightness
from gpu.denoise.atrous import Smoothing
from gpu.denoise.direct_history import DirectHistory
from gpu.denoise.indirect_history import IndirectHistory
from gpu.denoise.reprojection import PreviousFrame
from gpu.device_scene.features import scene_features
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import pixel_place
from gpu.gbuffer.camera_rays import CameraData, camera_data
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.irradiance import allocate_indirect
from gpu.methods.view_overlap import view_overlap
from gpu.scene.types import Camera
from gpu.settings import EVERY_SKIP, Skips

# What a walk sees is about so far away, in unit space; when less of it than this was seen before, nothing is built on.
USUAL_DISTANCE = 0.3
LEAST_SEEN_AGAIN = 0.5


class ViewState:
    """An image of `size` (width, height) of a scene; `radiance` (pixel,) is what the method of a renderer fills.

    `soft` (pixel,) is direct light of lights with an extent, `indirect` the indirect light, each before it is added;
    `needs` is what kernels must know of the scene; `walks` tells whether the frame may build on the last one, `rests`
    whether that had the same camera. A method whose frames leave their light in `history` and `direct_history`, and
    what they saw in `last`, says so by `kept`; `step` is the number of such frames before this one in a walk. `seed`
    and `moment` (1,) are the frame's own; `brightness` is that of indirect light. stride: of the pixels that are shaded
    (gpu.gbuffer.sparse_shading).
    """

    def __init__(
        self,
        device_scene: DeviceScene,
        size: tuple[int, int],
        *,
        lambertian: bool,
        skip: Skips = EVERY_SKIP,
        stride: int = 1,
    ) -> None:
        self.device_scene, self.size, self.device = device_scene, size, device_scene.device
        self.pixels = size[0] * size[1]
        self.scene = device_scene.view(lambertian=lambertian, skip=skip)
        self._backdrop = not skip.empty_pixels
        self.needs = scene_features(device_scene.scene, lambertian=lambertian, skip=skip)
        self.walks = self.rests = False
        self.step = 0
        self._last_camera: Camera | None = None
        self.kept = False
        self.seed = wp.zeros(1, dtype=int, device=self.device)
        self.moment = wp.zeros(1, dtype=int, device=self.device)
        self._camera = StagingBuffer(wp.zeros(1, dtype=CameraData, device=self.device))
        self.camera = self._camera.array
        self.radiance = wp.zeros(self.pixels, dtype=wp.vec3, device=self.device)
        self.gbuffer: GBuffer = allocate(GBuffer, self.pixels, self.device)
        self.soft = wp.zeros(self.pixels, dtype=wp.vec3, device=self.device)
        self.smoothing, self.side_smoothing = Smoothing(size, self.device), Smoothing(size, self.device)
        self.history = IndirectHistory(size, self.device)
        self.direct_history = DirectHistory(size, self.device)
        self.last = PreviousFrame(self.pixels, self.device)
        self.indirect = allocate_indirect(self.pixels, self.device)
        self.shading_points = ShadingPoints(size, stride, self.device)
        self.brightness = MeanBrightness(self.device)

    def look(self, camera: Camera, sample: int = 0, *, walks: bool = False) -> None:
        """Look through `camera`, whose own aspect gives way to the image's, for frame `sample` of a still view.

        walks: the frame may build on the last one, if that saw much the same. The device is done with that.
        """
        aspect, placement = self.size[0] / self.size[1], self.device_scene.scene.placement
        self.walks = (
            walks
            and self._last_camera is not None
            and view_overlap(camera, self._last_camera, aspect, USUAL_DISTANCE / placement.scale) >= LEAST_SEEN_AGAIN
        )
        self.rests = self._last_camera is not None and camera.view_key == self._last_camera.view_key
        self._last_camera = camera
        self.step = self.step + 1 if self.walks and self.kept else 0
        self.kept = False
        self.shading_points.follows.fill_(int(self.step > 0 or (sample > 0 and self.rests)))
        wp.copy(self.shading_points.before, self.camera)
        data: Any = camera_data(camera, placement, aspect, pixel_place(sample))
        self._camera.host[0] = data.numpy_value()
        self._camera.upload()

    def find_shading_points(self) -> None:
        """Trace the primary rays and list the pixels that meet a surface."""
        trace_primary_rays(
            self.device_scene, self.scene, self.camera, self.size, self.gbuffer, self.needs, backdrop=self._backdrop
        )
        self.shading_points.find(self.gbuffer)

    def add_indirect(self) -> None:
        """Add the indirect light to the picture."""
        self.shading_points.reflect(self.gbuffer, self.indirect.irradiance, self.brightness.value, self.radiance)
