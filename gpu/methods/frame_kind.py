"""What is done in a frame: in the first of a view, in those of a walk, and in those that a still view averages."""

from dataclasses import dataclass

from gpu.methods.view_state import ViewState
from gpu.settings import RenderSettings


@dataclass(frozen=True)
class StillViewParameters:
    """How frames of a still view differ.

    smoothed_frames: smoothing blurs shadows a little. It helps the first frames; those after so many are averaged, not
    smoothed, so that the mean forgets the blur. smoothed_weight: what a smoothed one counts for where others converge,
    which have several times its error, nearly all of it noise. refining_samples: of direct light these have at least,
    since its noise would be most of the mean's. interpolated_frames: those after so many shade every pixel: light
    between SPs is interpolated in earlier ones, which have less noise for it, and the mean forgets that blur, too.
    frames_a_set: that a light set of many_vpls or more serves: making it takes as long as such a frame, and sets differ
    by little beside the noise of the SPs' own rays. Those of fewer VPLs differ much and are soon made.
    """

    smoothed_frames: int = 4
    refining_samples: int = 4
    smoothed_weight: float = 3.0
    interpolated_frames: int = 64
    frames_a_set: int = 4
    many_vpls: int = 1 << 16


STILL_VIEW_PARAMETERS = StillViewParameters()


def frame_seed(seed: int, number: int) -> int:
    """The seed of frame `number` of a still view or a walk; that of the first is `seed` itself."""
    return (seed + 0x9E3779B9 * number) % 2**31


@dataclass(frozen=True)
class FrameKind:
    """What is done in a frame.

    sample: its number among those of a still view; index: that, or its number in a walk: frames with another have
    samples of their own; seed: of these; refines: it is one of those that make a still view's mean sharp; shades_all:
    every pixel is shaded, none interpolated; denoise: light is shared between neighbouring pixels; read_history,
    write_history: light of a walk's frames before is built on, or left to the next. captured: its stages launch what
    those of other frames of this kind do.
    """

    sample: int
    index: int
    seed: int
    refines: bool
    shades_all: bool
    denoise: bool
    read_history: bool
    write_history: bool

    @property
    def captured(self) -> bool:
        """Whether its launches may be replayed: frames of a still view but the first have samples of their own."""
        return self.sample == 0


def leaves_history(settings: RenderSettings) -> bool:
    """Whether frames of a walk leave to the next what they found."""
    return settings.skip.temporal_reuse and settings.smooth


def frame_kind(settings: RenderSettings, view: ViewState, sample: int) -> FrameKind:
    """That of frame `sample` of a still view, or of a walk where it is 0."""
    refines, index = sample >= STILL_VIEW_PARAMETERS.smoothed_frames, sample or view.history_length
    return FrameKind(
        sample=sample,
        index=index,
        seed=frame_seed(settings.seed, index),
        refines=refines,
        shades_all=sample >= STILL_VIEW_PARAMETERS.interpolated_frames,
        denoise=settings.smooth and not refines,
        read_history=sample == 0 and view.history_length > 0,
        write_history=sample == 0 and leaves_history(settings),
    )


def light_samples(usual: int, kind: FrameKind) -> int:
    """Samples of direct light that a pixel has in a frame of this kind, where it usually has so many."""
    return max(usual, STILL_VIEW_PARAMETERS.refining_samples) if kind.refines else usual
