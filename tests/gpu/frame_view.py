"""A viewer and the arrays of its frames in one, for tests of the stages that methods run on both."""

from typing import Any

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.view_state import ViewState
from gpu.scene.types import Camera
from gpu.settings import EVERY_SKIP, Skips


class FrameView(ViewState):
    """As gpu.methods.fuzzy_view_state.FuzzyViewState, without clusters; what it has not, its FrameArrays have."""

    def __init__(
        self,
        device_scene: DeviceScene,
        size: tuple[int, int],
        *,
        lambertian: bool,
        skip: Skips = EVERY_SKIP,
        stride: int = 1,
        traces_lobes: bool = False,
    ) -> None:
        super().__init__(device_scene, size)
        kinds = {"lambertian": lambertian, "traces_lobes": traces_lobes}
        self.frame = FrameArrays(device_scene, size, **kinds, skip=skip, stride=stride)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["frame"], name)

    def set_camera(self, camera: Camera, sample: int = 0, *, walks: bool = False) -> None:
        wp.copy(self.shading_points.before.camera, self.camera)
        super().set_camera(camera, sample, walks=walks)
        self.shading_points.before.follows.fill_(int(self.history_length > 0 or (sample > 0 and self.is_still)))

    def find_shading_points(self) -> None:
        self.frame.trace_primary_rays(self.camera)
        self.shading_points.find(self.gbuffer)
