"""What one viewer wants and has been sent. The newest pose wins, and only a few frames are unacknowledged. No I/O here.

While the view changes, each frame is a picture of its own, as small as it must be to come in time. When the view has
rested for a moment it is rendered at full size, then again and again with other samples, and averaged; some of these
means are sent, until one has as many frames as were wanted. Then nothing is due before something changes. A walk whose
frames were whole leaves its last one to the mean, so that nothing changes as it comes to rest.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from time import monotonic

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, SceneEdits
from gpu.settings import RenderSettings
from server.render.schedule import Urgency
from server.render.turns import samples_a_turn
from server.walk.ack_window import AckWindow
from server.walk.frame_request import FrameRequest
from server.walk.resolution_scaler import LEAST_GPU_PIXELS, ResolutionScaler
from server.walk.video_choice import VideoChoice
from server.wire.browser import CodecName, Pose, Stream
from server.wire.frame_header import LOSSLESS, Codec, FrameHeader, Phase
from server.wire.worker import CameraMatrix, Done, Output, Render, SceneRef

MAX_LOSSES = 3  # of the worker in a row, before a view is blamed for them
REST_SECONDS = 0.15  # without a new pose, before a view counts as still
# A still frame that takes long would keep the next motion waiting: the view must have rested for longer.
LONG_FRAME_MS, LONG_REST_SECONDS = 300.0, 0.6
# Times that the sides of still frames are halved when the device has too little memory, before that is an error.
MAX_SHRINKS = 2
# Samples a pixel of each frame of a method that refines by samples: few, so that frames come soon.
SAMPLES_A_FRAME = 4
CODECS: dict[Output, Codec] = {".png": Codec.PNG, "h264": Codec.H264}


@dataclass(frozen=True)
class Qualities:
    """JPEG qualities, 1 to 100, of moving and of still frames."""

    moving: int = 80
    still: int = 92


class Session:
    """The state of one viewer.

    `scene` is None until one is open. A frame is due when there is something new to show and room in the window, unless
    these settings have failed. codecs: that frames may come in besides JPEG; on_gpu: whether a GPU renders them.
    """

    def __init__(
        self,
        viewer: int,
        size: tuple[int, int],
        settings: RenderSettings,
        *,
        stream: Stream = Stream(),  # noqa: B008
        qualities: Qualities = Qualities(),
        codecs: Collection[CodecName] = (),
        on_gpu: bool = False,
        now: Callable[[], float] = monotonic,
    ) -> None:
        self.viewer = viewer
        self.scene: SceneRef | None = None
        self.window = AckWindow(now)
        self._size = size
        self._settings = settings
        self._stream = stream
        self._qualities = qualities
        self._takes_png, self._takes_video = "png" in codecs, "h264" in codecs
        self._video_choice = VideoChoice(now)
        self._video = 0  # pictures of it that were asked for
        self._settings_id = 0
        self._edits, self._own = NO_EDITS, False
        self._pose: Pose | None = None
        self._scaler = ResolutionScaler(LEAST_GPU_PIXELS if on_gpu else 0)
        self._now = now
        self._changed_at = 0.0
        self._fresh = False  # something changed since the last moving frame was asked for
        self._view = 0  # counts changes of what is seen
        self._averaged = 0  # frames of the still view that were asked for
        self._target_frames = settings.frames
        self._still_ms = 0.0  # what a still frame took
        self._moving_size = (0, 0)  # of the last frame of a walk
        self._shrinks = 0
        self._blocked = False  # these settings failed: wait for others
        self._losses = 0  # workers lost in a row while rendering for this viewer
        self._lost_view = -1  # the newest view that may have lost a frame with the last of them
        self._last_frame = 0  # its id

    @property
    def due(self) -> Urgency | None:
        """How urgent the frame is that should be rendered now; None when none is due."""
        if self.scene is None or self._pose is None or self._blocked:
            return None
        if self._fresh:
            return Urgency.MOVING if self.window.room else None
        if self._target_frames is not None and self._averaged >= self._target_frames:
            return None
        if self.rest_seconds > 0.0 or not self.window.room:
            return None
        return Urgency.REFINING if self._averaged else Urgency.STILL

    @property
    def rest_seconds(self) -> float:
        """For how long the view must still rest before it counts as still."""
        rest = LONG_REST_SECONDS if self._still_ms > LONG_FRAME_MS else REST_SECONDS
        return max(self._changed_at + rest - self._now(), 0.0)

    def pose(self, pose: Pose) -> None:
        """The viewer has moved. Poses are dropped while no scene is open: they are meant for the last one."""
        if self.scene is None:
            return
        before, self._pose = self._pose, pose
        if before is None or (before.matrix, before.yfov, before.near) != (pose.matrix, pose.yfov, pose.near):
            self._touch()

    def change(
        self,
        settings_id: int,
        size: tuple[int, int] | None = None,
        settings: RenderSettings | None = None,
        stream: Stream | None = None,
    ) -> None:
        """The viewer wants other frames from now on; what is None stays."""
        self._settings_id = settings_id
        self._size = size or self._size
        self._settings = settings or self._settings
        self._stream = stream or self._stream
        if settings is not None:
            self._scaler.restart()
        self._restart()
        self._touch()

    def edit(self, edits: SceneEdits, *, own: bool = False) -> bool:
        """The scene differs by these from its file from now on, own: for this viewer alone; whether that is new.

        Then it looks different.
        """
        if (self._edits, self._own) == (edits, own):
            return False
        self._edits, self._own = edits, own
        self._blocked = False
        self._touch()
        return True

    def show(self, scene: SceneRef | None, edits: SceneEdits = NO_EDITS) -> None:
        """From now on this scene, from a pose that is yet to come; None while the next one is being opened."""
        self.scene, self._edits, self._own = scene, edits, False
        self._pose = None
        self._scaler.restart()
        self._restart()

    def sent(self, header: FrameHeader, size: int) -> None:
        """A frame of `size` bytes is on its way."""
        self.window.sent(header.frame)
        if header.phase is Phase.MOVING:
            self._video_choice.sent(header.frame, size, is_video=header.codec is not Codec.JPEG)

    def acknowledge(self, frame: int, *, broken: bool = False) -> None:
        """The viewer is done with this frame and all before it; UserError when it cannot have it.

        broken: it could not be decoded.
        """
        if frame > self.window.newest:  # one that is still being rendered would leave the window open for ever more
            raise UserError(f"ack.frame: frame {frame} has not been sent; the last one was {self.window.newest}")
        self.window.acknowledge(frame)
        self._video_choice.acknowledged(frame)
        if broken:
            self._video += 1  # what follows does not follow on: it is a key frame

    def take(self) -> tuple[FrameRequest, Render] | None:
        """The newest view as a job for the worker, or None when no frame is due any more."""
        urgency = self.due
        if urgency is None or self.scene is None or self._pose is None:
            return None
        pose, settings = self._pose, self._settings
        if settings.method.refines_by_samples and settings.samples is None:
            settings = settings.model_copy(update={"samples": SAMPLES_A_FRAME})
        wanted_at, samples, video = self._changed_at, None, 0
        output: Output = "jpeg"
        if urgency is Urgency.MOVING:
            self._fresh = False
            size = self._scaler.size(self._still_size, settings, self._stream.motion_scale)
            self._moving_size = size
            sample, walks, quality = None, True, self._qualities.moving
            if self._takes_video and (self._video_choice.is_video if (wish := self._stream.video) is None else wish):
                self._video += 1
                output, video = "h264", self._video
        else:
            wanted_at = self._changed_at + REST_SECONDS if urgency is Urgency.STILL else self._now()
            sample, size, quality = self._averaged, self._still_size, self._qualities.still
            self._averaged = samples = self._averaged + 1
            # Counts for a target are chosen for walks and for views that rest apart.
            walks = sample == 0 and size == self._moving_size and not settings.has_target
            if not self._shown(samples):
                output = "none"
            elif samples == self._target_frames and self._stream.lossless and self._takes_png:
                output, quality = ".png", LOSSLESS
        render = Render(
            self.viewer,
            self.scene,
            CameraMatrix(pose.matrix, pose.yfov, pose.near),
            size,
            _for_a_turn(settings, size),
            output,
            sample=sample,
            walks=walks,
            quality=quality,
            edits=self._edits,
            own=self._own,
            video=video,
        )
        return self._request(render, wanted_at, samples), render

    def delivered(self, request: FrameRequest, done: Done, waited_ms: float) -> None:
        """A frame was rendered, after it had waited for its turn."""
        self._losses = 0
        if request.samples is None:
            if request.settings == self._settings_id:
                self._scaler.observe(done.render_ms, waited_ms)
        elif request.view == self._view:
            self._still_ms = done.render_ms
            self._target_frames = done.target
            if done.samples < request.samples:  # the worker did not have the others any more
                self._averaged = done.samples
                self._view += 1  # the next one is on its way and will say so too, which must not count again

    def failed(self, request: FrameRequest) -> bool:
        """A frame could not be rendered: none is tried again before the settings change; False when that was known."""
        self._forget(request)
        known = self._blocked
        self._blocked = known or request.settings == self._settings_id
        return not known

    def shrink(self, request: FrameRequest) -> bool:
        """The device had too little memory for a frame: smaller ones from now on; False when they are that already."""
        self._forget(request)
        if request.settings != self._settings_id:
            return True
        self._shrinks += 1
        self._blocked = self._shrinks > MAX_SHRINKS
        self._touch()
        return not self._blocked

    def lost(self, request: FrameRequest, *, innocent: bool = False) -> bool:
        """The worker died with a frame: it is tried again; False when that happened too often with these settings.

        innocent: it died in another's turn, which does not count.
        """
        self._forget(request)
        if request.view > self._lost_view:  # else it went with the same worker as the one before
            self._losses += not innocent
            self._lost_view = self._view
            self._view += 1
        self._fresh = True
        self._averaged = 0
        self._blocked = self._losses >= MAX_LOSSES
        return not self._blocked

    @property
    def _still_size(self) -> tuple[int, int]:
        width, height = self._size
        return max(1, width >> self._shrinks), max(1, height >> self._shrinks)

    def _shown(self, samples: int) -> bool:
        """Whether the picture of so many frames is sent: each differs from the last one by about as much."""
        return samples & (samples - 1) == 0 or samples == self._target_frames

    def _request(self, render: Render, wanted_at: float, samples: int | None) -> FrameRequest:
        assert self._pose is not None
        frame = None
        if render.output != "none":
            self._last_frame += 1
            frame = self._last_frame
            self.window.add(frame)
        waited = 1e3 * max(self._now() - wanted_at, 0.0)
        codec = CODECS.get(render.output, Codec.JPEG)
        return FrameRequest(frame, self._pose.id, self._settings_id, waited, self._view, samples, render.quality, codec)

    def _forget(self, request: FrameRequest) -> None:
        if request.frame is not None:
            self.window.drop(request.frame)

    def _restart(self) -> None:
        self._blocked = False
        self._losses = 0
        self._shrinks = 0
        self._still_ms = 0.0
        self._target_frames = self._settings.frames

    def _touch(self) -> None:
        self._view += 1
        self._fresh = True
        self._averaged = 0
        self._changed_at = self._now()


def _for_a_turn(settings: RenderSettings, size: tuple[int, int]) -> RenderSettings:
    """With no more samples than a turn takes; those of the frames that follow add to them."""
    if settings.samples is None or settings.samples <= (most := samples_a_turn(settings, size)):
        return settings
    return settings.model_copy(update={"samples": most})
