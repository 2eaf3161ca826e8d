"""What pictures cost before they are rendered, by their rays and how fast those of the same kind were traced."""

from dataclasses import dataclass
from math import sqrt
from os import cpu_count

from gpu.errors import UserError
from gpu.methods.rays import frame_rays
from gpu.sample_counts import sample_counts_of
from gpu.settings import RenderSettings
from server.wire.worker import Render, SceneRef

# Rays a second until some were timed: more than scenes have, so that what is refused takes too long for sure.
CUDA_RAYS, CPU_RAYS = 4e9, 5e6 * (cpu_count() or 1)
TELLING_SECONDS = 0.2  # a frame that takes less says little of long ones
MOST = 1000  # scenes and methods that are remembered


class TooLongError(UserError):
    """It would take the device for longer than may be (422)."""


@dataclass(frozen=True)
class Kind:
    """Pictures that cost alike for each ray: of a scene, by a method."""

    scene: SceneRef
    method: str

    @classmethod
    def of(cls, scene: SceneRef, settings: RenderSettings) -> "Kind":
        """That of pictures with these settings."""
        return cls(scene, f"{settings.method} {settings.clustering}")


@dataclass(frozen=True)
class Cost:
    """Of a frame: its pixels and about how many rays they take."""

    pixels: int
    rays: float


@dataclass(frozen=True)
class _Device:
    is_cuda: bool


def frame_cost(size: tuple[int, int], settings: RenderSettings, *, cuda: bool) -> Cost:
    """What a frame takes on a GPU or, where that is not so, on a CPU."""
    pixels = size[0] * size[1]
    return Cost(pixels, frame_rays(settings, sample_counts_of(settings, _Device(cuda)), pixels))


class Speeds:
    """How fast rays were traced, for each kind of pictures: its first frame does not count, and then the fastest one,
    since kernels may have been compiled in others.
    """

    def __init__(self) -> None:
        self._rays: dict[Kind, float] = {}  # a second, in the order of the last use

    def learn(self, job: Render, seconds: float, *, cuda: bool) -> None:
        """A frame took so long."""
        if seconds < TELLING_SECONDS:
            return
        kind, speed = Kind.of(job.scene, job.settings), frame_cost(job.size, job.settings, cuda=cuda).rays / seconds
        self._rays[kind] = max(speed, self._rays.pop(kind)) if kind in self._rays else 0.0
        if len(self._rays) > MOST:
            del self._rays[next(iter(self._rays))]

    def seconds(self, job: Render, *, cuda: bool) -> float:
        """What a frame of a job is expected to take."""
        usual = CUDA_RAYS if cuda else CPU_RAYS
        return frame_cost(job.size, job.settings, cuda=cuda).rays / (
            self._rays.get(Kind.of(job.scene, job.settings)) or usual
        )

    def check(self, job: Render, frames: int, most_seconds: float, *, cuda: bool, pictures: int = 1) -> None:
        """TooLongError, with what would do, where pictures of so many frames each are expected to take too long."""
        seconds = pictures * frames * self.seconds(job, cuda=cuda)
        if seconds <= most_seconds:
            return
        (width, height), share = job.size, most_seconds / seconds
        side = sqrt(share)
        film, each = (f"{pictures} pictures of ", " each") if pictures > 1 else ("", "")
        fewer = f", {int(share * frames)} frames{each}" if share * frames >= 1.0 else ""
        fewer += f", {int(share * pictures)} pictures" if pictures > 1 and share * pictures >= 1.0 else ""
        raise TooLongError(
            f"size: {film}{width}×{height} pixels with these settings and {frames} frames{each} are expected to take "
            f"{_words(seconds)}, more than the {_words(most_seconds)} of max_render_seconds of this server: ask for "
            f"at most {max(int(side * width), 1)}×{max(int(side * height), 1)} pixels{fewer}, or fewer samples or VPLs"
        )


def _words(seconds: float) -> str:
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:,.0f} {unit}"
    return f"{seconds:.3g} s"
