"""What one viewer's walk leaves behind for its next frame, whatever the method."""

from collections.abc import Hashable

import warp as wp

from gpu.core.stages import Stages, new_number
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import pixel_place
from gpu.gbuffer.camera_rays import CameraData, camera_values
from gpu.methods.view_overlap import VIEW_OVERLAP_PARAMETERS, is_seen_again
from gpu.scene.types import Camera


class ViewState:
    """A viewer of pictures of `size` (width, height): its camera, its last picture, and what that may serve for.

    radiance (pixel,) [W/m²/sr]: what the method fills; camera (1,): CameraData; reuses_history: whether the frame may
    build on the last one; is_still: whether that had the same camera. A method whose frames leave something to the next
    says so by `wrote_history`; history_length: the number of such frames before this one in a walk. antialiases: each
    of these looks through another place in the pixels. shown: what `radiance` is of, None when that is no sound
    picture; version, surface_version: of the scene's light and surfaces then (gpu.vpl.light_sets); number: of this view
    alone, for captured graphs.
    """

    def __init__(self, device_scene: DeviceScene, size: tuple[int, int]) -> None:
        self.size, self.device = size, device_scene.device
        self.pixels = size[0] * size[1]
        self.number = new_number()
        self._placement = device_scene.scene.placement
        self._camera = StagingBuffer(wp.zeros(1, dtype=CameraData, device=self.device))
        self.camera = self._camera.array
        self.radiance = wp.zeros(self.pixels, dtype=wp.vec3, device=self.device)
        self._last_camera: Camera | None = None
        self.reuses_history = self.is_still = self.wrote_history = self.antialiases = False
        self.history_length = 0
        self.version = self.surface_version = 0
        self.shown: Hashable = None
        self.walked = False
        self.statistics: tuple[dict[str, int], dict[str, int]] = {}, {}

    def forget(self) -> None:
        """Know nothing of frames before, which were of a scene that has changed."""
        self._last_camera, self.shown = None, None
        self.wrote_history = self.walked = False

    def forget_light(self) -> None:
        """Know nothing of the light of frames before; what they saw is as it was."""
        self.shown = None
        self.wrote_history = False

    def set_camera(self, camera: Camera, sample: int = 0, *, walks: bool = False, stages: Stages | None = None) -> None:
        """Look through `camera`, whose own aspect gives way to the image's, for frame `sample` of a still view.

        walks: the frame may build on the last one, if that saw much the same. The device is done with that. stages:
        the frame's, which the device learns of it with; None: at once.
        """
        self._look(camera, sample, walks=walks)
        if stages:
            stages.run_untimed(self._upload, branch="camera")
        else:
            self._upload()

    def _look(self, camera: Camera, sample: int, *, walks: bool) -> None:
        """All of `set_camera` that the host does."""
        last, aspect = self._last_camera, self.size[0] / self.size[1]
        distance = VIEW_OVERLAP_PARAMETERS.usual_distance / self._placement.scale
        self.reuses_history = walks and last is not None and is_seen_again(camera, last, aspect, distance)
        self.is_still = last is not None and camera.view_key == last.view_key
        self._last_camera = camera
        self.history_length = self.history_length + 1 if self.reuses_history and self.wrote_history else 0
        self.wrote_history = False
        place = pixel_place(sample or (self.history_length if self.antialiases else 0))
        self._camera.host[0] = camera_values(camera, self._placement, aspect, place)

    def _upload(self) -> None:
        """Tell the device."""
        self._camera.upload()
