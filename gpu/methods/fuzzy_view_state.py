"""What a walk with `fuzzy-vpl` leaves behind for its next frame, apart for each viewer: clusters and histories."""

from collections.abc import Callable
from dataclasses import dataclass
from weakref import WeakKeyDictionary, WeakSet

import warp as wp

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.staging_buffer import StagingBuffer
from gpu.denoise.antialiasing import PictureHistory
from gpu.denoise.direct_history import DirectHistory
from gpu.denoise.indirect_history import IndirectHistory
from gpu.denoise.reprojection import PreviousFrame
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.far_field import FarSums
from gpu.indirect.visibility import Visibility
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.passes import Histories
from gpu.methods.view_state import ViewState
from gpu.scene.types import Camera
from gpu.sp.sp_clustering import SpClustering


@dataclass
class KeptLight:
    """Of one light set: what representatives of the walk's last frame see of it, and the far light that they get.

    last_sample: the number in a still view of the frame that left this, None where none did; reads_history: whether
    the last frame built on light of those before; corrected: whether SPs that neighbours must not speak for had more
    rays in it; near: whether near-field light was looked for; relit: whether a walk's last frame had other light, and
    nothing is known of this but where its clusters are.
    """

    visibility: Visibility
    far: FarSums
    last_sample: int | None = None
    reads_history: bool = False
    corrected: bool = False
    near: bool = False
    relit: bool = False

    def begin(self, *, reads_history: bool, corrected: bool) -> None:
        """Begin a frame, which leaves nothing should it fail."""
        self.last_sample, self.relit, self.near = None, False, False
        self.reads_history, self.corrected = reads_history, corrected

    def for_another_viewer(self) -> "KeptLight":
        """One that knows nothing yet; both share what a frame only works with."""
        return KeptLight(self.visibility.for_another_viewer(), self.far.for_another_viewer())


class FuzzyViewState(ViewState):
    """A viewer's walk: its SP clusters, what these see by light set, and the light of its frames before.

    views: all viewers of the same size, which this one becomes one of: the arrays that one of them works with serve
    all; antialiases: whether their pictures are averaged.
    """

    clustering: SpClustering
    histories: Histories

    def __init__(
        self,
        frame: FrameArrays,
        views: "WeakSet[FuzzyViewState]",
        make_clustering: Callable[[], SpClustering],
        *,
        antialiases: bool,
    ) -> None:
        super().__init__(frame.device_scene, frame.size)
        self.antialiases = antialiases
        other = next(iter(views), None)
        self._views, size = views, frame.size
        views.add(self)
        self.points = frame.shading_points.for_another_viewer()
        self._follows = StagingBuffer(self.points.before.follows)
        self.lights: WeakKeyDictionary[object, KeptLight] = WeakKeyDictionary()
        previous = PreviousFrame(frame.size, self.device)
        if other:
            self.clustering, histories = other.clustering.for_another_viewer(), other.histories
            direct = histories.direct and histories.direct.for_another_viewer()
            gloss = histories.gloss and histories.gloss.for_another_viewer()
            indirect = histories.indirect.for_another_viewer()
            pictures = histories.pictures and histories.pictures.for_another_viewer()
        else:
            DEVICE_SHARING.pause()
            self.clustering = make_clustering()
            DEVICE_SHARING.pause()
            direct = DirectHistory(size, self.device) if frame.features.soft else None
            gloss = DirectHistory(size, self.device) if frame.gloss else None
            indirect = IndirectHistory(size, self.device)
            DEVICE_SHARING.pause()
            pictures = PictureHistory(size, self.device) if antialiases else None
        self.histories = Histories(direct, gloss, indirect, pictures, previous)

    def lights_of_others(self, lights: object) -> KeptLight | None:
        """What another viewer knows of these lights, if any does."""
        return next((other.lights[lights] for other in self._views if lights in other.lights), None)

    def forget(self) -> None:
        """As any viewer does: what clusters have seen was of other light."""
        super().forget()
        for kept in self.lights.values():
            kept.last_sample, kept.relit = None, False

    def forget_light(self) -> None:
        """As any viewer does; what clusters have seen was of other light, but they are where they were."""
        super().forget_light()
        for kept in self.lights.values():
            kept.last_sample, kept.relit = None, kept.relit or kept.last_sample == 0

    def _look(self, camera: Camera, sample: int, *, walks: bool) -> None:
        """As any viewer does; where the frame before saw much the same, pixels where light ended then are shaded."""
        super()._look(camera, sample, walks=walks)
        self._follows.host[0] = self.history_length > 0 or (sample > 0 and self.is_still)

    def _upload(self) -> None:
        wp.copy(self.points.before.camera, self.camera)
        super()._upload()
        self._follows.upload()

    def antialias(self, gbuffer: GBuffer, *, read_history: bool) -> None:
        """Make of this frame's picture the mean of all frames'; read_history: it may build on the last one."""
        if pictures := self.histories.pictures:
            inputs = gbuffer, self.camera, self.histories.previous, self.radiance
            pictures.take(*inputs, read_history=read_history)

    def keep(self, gbuffer: GBuffer, *, light: bool) -> None:
        """Leave to the next frame what this one saw, and its indirect `light`."""
        if light:
            self.histories.indirect.keep(self.points)
        self.histories.previous.keep(gbuffer, self.camera)
