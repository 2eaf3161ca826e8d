"""A frame that a viewer is to get: what was asked of the worker, and what is said of it when it is sent."""

from dataclasses import dataclass

from server.wire.frame_header import Codec, FrameHeader, Phase
from server.wire.worker import Done


@dataclass(frozen=True)
class FrameRequest:
    """A frame that is being rendered: what it shows, and how long that had waited [ms].

    frame: its id, None for one that is averaged and not shown; view: counts changes of what is seen, and losses of
    what was averaged; samples: frames that the picture is to average, None for a moving one; quality, codec: of the
    image.
    """

    frame: int | None
    pose: int
    settings: int
    queue_ms: float
    view: int
    samples: int | None
    quality: int
    codec: Codec

    @property
    def refines(self) -> bool:
        """Whether it only makes sharper what the viewer sees already."""
        return self.samples is not None and self.samples > 1

    def header(self, done: Done) -> FrameHeader:
        """What is sent before the image of a frame that is shown."""
        assert self.frame is not None
        width, height = done.size
        codec = Codec.H264_KEY if self.codec is Codec.H264 and done.is_key else self.codec
        phase = Phase.MOVING
        if self.samples is not None:
            phase = Phase.FINAL if done.samples >= done.target else Phase.STILL
        return FrameHeader(
            width=width,
            height=height,
            pose=self.pose,
            frame=self.frame,
            settings=self.settings,
            queue_ms=self.queue_ms,
            render_ms=done.render_ms,
            encode_ms=done.encode_ms,
            stage_ms=done.stage_ms,
            codec=codec,
            phase=phase,
            quality=self.quality,
            samples=done.samples,
            target_samples=1 if self.samples is None else done.target,
        )
