"""What one viewer's walk leaves behind for its next frame, whatever the method."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from gpu.core.stages import new_number
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import pixel_place
from gpu.gbuffer.camera_rays import BLIND_CAMERA, CameraData, camera_values
from gpu.methods.view_overlap import VIEW_OVERLAP_PARAMETERS, view_overlap
from gpu.scene.types import Camera


@dataclass
class TileWalk:
    """The walk of a tile's camera.

    last: that of the last frame, None where nobody looked; follows: whether the frame may build on that one; length:
    the number of frames before this one that it builds on.
    """

    last: Camera | None = None
    follows: bool = False
    length: int = 0


class ViewState:
    """A viewer of pictures of `size` (width, height): its camera, its last picture, and what that may serve for.

    So are several viewers whose pictures are `tiles` of one frame (gpu.core.image_size), each with a walk of its own.

    radiance (pixel,) [W/m²/sr]: what the method fills; camera (tile,): CameraData; reuses_history: whether any tile's
    frame may build on the last one; is_still: whether that had the same cameras. A method whose frames leave something
    to the next says so by `wrote_history`; history_length: the number of such frames before this one in a walk.
    antialiases: each of these looks through another place in the pixels. shown: what `radiance` is of, None when that
    is no sound picture; version, surface_version: of the scene's light and surfaces then (gpu.vpl.light_sets); number:
    of this view alone, for captured graphs.
    """

    def __init__(self, device_scene: DeviceScene, size: tuple[int, int], tiles: int = 1) -> None:
        self.size, self.device = size, device_scene.device
        self.pixels = tiles * size[0] * size[1]
        self.number = new_number()
        self._placement = device_scene.scene.placement
        self._camera = StagingBuffer(wp.zeros(tiles, dtype=CameraData, device=self.device))
        self.camera = self._camera.array
        self.radiance = wp.zeros(self.pixels, dtype=wp.vec3, device=self.device)
        self.walks = [TileWalk() for _ in range(tiles)]
        self.reuses_history = self.is_still = self.wrote_history = self.antialiases = False
        self.history_length = 0
        self.version = self.surface_version = 0
        self.shown: Hashable = None
        self.walked = False
        self.statistics: tuple[dict[str, int], dict[str, int]] = {}, {}

    def forget(self) -> None:
        """Know nothing of frames before, which were of a scene that has changed."""
        for walk in self.walks:
            walk.last = None
        self.shown = None
        self.wrote_history = self.walked = False

    def forget_light(self) -> None:
        """Know nothing of the light of frames before; what they saw is as it was."""
        self.shown = None
        self.wrote_history = False

    def set_camera(self, camera: Camera, sample: int = 0, *, walks: bool = False) -> None:
        """As `set_cameras`, where there is one tile."""
        self.set_cameras((camera,), sample, walks=walks)

    def set_cameras(self, cameras: Sequence[Camera | None], sample: int = 0, *, walks: bool = False) -> None:
        """Look through a camera for each tile, whose own aspect gives way to the tile's, for frame `sample` of a still
        view; None where nobody looks.

        walks: the frame may build on the last one, where that saw much the same. The device is done with that.
        """
        pairs = list(zip(self.walks, cameras, strict=True))
        self.is_still = all((walk.last and walk.last.view_key) == (it and it.view_key) for walk, it in pairs)
        for tile, (walk, camera) in enumerate(pairs):
            walk.follows = walks and camera is not None and self._sees_much_of_last(walk, camera)
            walk.length = walk.length + 1 if walk.follows and self.wrote_history else 0
            walk.last = camera
            self._camera.host[tile] = self._values(camera, sample or (walk.length if self.antialiases else 0))
        self.reuses_history = any(walk.follows for walk in self.walks)
        self.history_length = self.history_length + 1 if self.reuses_history and self.wrote_history else 0
        self.wrote_history = False
        self._camera.upload()

    def frame_numbers(self, sample: int) -> list[int]:
        """Each tile's, among frames of its walk, or of a still view where its `sample` is not 0."""
        return [sample or walk.length for walk in self.walks]

    def _sees_much_of_last(self, walk: TileWalk, camera: Camera) -> bool:
        if walk.last is None:
            return False
        chosen, aspect = VIEW_OVERLAP_PARAMETERS, self.size[0] / self.size[1]
        overlap = view_overlap(camera, walk.last, aspect, chosen.usual_distance / self._placement.scale)
        return overlap >= chosen.min_overlap

    def _values(self, camera: Camera | None, number: int) -> tuple[Any, ...]:
        """A camera as kernels see it in a frame of this number, each of which looks through another place."""
        if camera is None:
            return BLIND_CAMERA
        return camera_values(camera, self._placement, self.size[0] / self.size[1], pixel_place(number))
