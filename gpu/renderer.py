"""A renderer: one image size and one choice of settings of a resident scene, one frame after the other."""

from collections import deque
from collections.abc import Hashable
from dataclasses import replace
from math import pi, sin
from statistics import median
from time import perf_counter

import warp as wp

from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame, FrameStats
from gpu.film.tonemap import Tonemap
from gpu.gbuffer.sparse_shading import stride_of
from gpu.methods.exact_vpl import ExactVpl
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.passes import FrameStatistics, RenderMethod
from gpu.methods.path import PathTracing
from gpu.methods.targeted import TargetedVpl
from gpu.methods.view_state import ViewState
from gpu.sample_counts import sample_counts_of
from gpu.scene.camera import rotated
from gpu.scene.types import Camera
from gpu.settings import Clustering, Method, RenderSettings, Skips
from gpu.vpl.light_sets import Progress, light_sets_of

MAX_SIDE = 16_384
# Frames that nobody sees, until the counts of the first picture meet its target.
SETTLING_FRAMES = 32
# In those of a walk the camera sways, so far to either side and so many frames to and fro: frames that see nothing new
# would take less than others.
SWAY_DEGREES, SWAY_FRAMES = 4.0, 16
# Of a frame with a wanted error.
MOST_TRIES = 8
# What the host takes varies more than what a device does: so many frames tell what it takes.
HOST_FRAMES = 15


def _swayed(camera: Camera, number: int) -> Camera:
    return rotated(camera, SWAY_DEGREES * sin(2.0 * pi * (number + 1) / SWAY_FRAMES))


def _silent(what: str, fraction: float) -> None:
    """Report progress to nobody."""


class Renderer:
    """Renders `device_scene` at `size` (width, height) with `settings`; its arrays are allocated once.

    progress(what, fraction) is called during long work, the first time light is traced above all.
    Raises UserError when a side of `size` is not within 1 … 16384 pixels.
    """

    def __init__(
        self,
        device_scene: DeviceScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress | None = None,
    ) -> None:
        if not all(1 <= side <= MAX_SIDE for side in size):
            raise UserError(f"size: each side must be 1 to {MAX_SIDE} pixels, got {size[0]}x{size[1]}")
        self._progress = progress or _silent
        self._settings = settings
        stride = stride_of(size[0] * size[1]) if settings.skip.interpolated and self._is_fuzzy() else 1
        self._view = ViewState(device_scene, size, lambertian=settings.lambertian, skip=settings.skip, stride=stride)
        self._stages = Stages(device_scene.device)
        self._tonemap = Tonemap(self._view.pixels, device_scene.device)
        self._targeted: TargetedVpl | None = None
        self._settled: set[bool] = set()
        self._method = self._make_method(device_scene)
        # What the last picture is of, and what it was made of: none when there is no sound one.
        self._shown: tuple[Hashable, int] | None = None
        self._statistics: FrameStatistics = {}, {}
        self._walked = False
        # What frames of a walk, and others, took beside their stages; and learning of the last one [ms].
        self._host_ms = {walks: deque([0.0], HOST_FRAMES) for walks in (False, True)}
        self._learning_ms = 0.0

    def _is_fuzzy(self) -> bool:
        return self._settings.method is Method.FUZZY_VPL and self._settings.clustering is not Clustering.VPLS

    def _make_method(self, device_scene: DeviceScene) -> RenderMethod:
        settings = self._settings
        sample_counts, light_sets = sample_counts_of(settings, device_scene.device), light_sets_of(device_scene)
        if settings.has_target:
            self._targeted = TargetedVpl(self._view, settings, sample_counts, light_sets, self._progress)
            return self._targeted
        method = PathTracing if settings.method is Method.PATH else FuzzyVpl if self._is_fuzzy() else ExactVpl
        return method(self._view, settings, sample_counts, light_sets, self._progress)

    def render(self, camera: Camera, accumulation: Accumulation | None = None, *, walks: bool = False) -> Frame:
        """The picture from `camera`, ready when the call returns.

        With an `accumulation`, of this camera's earlier frames and as many pixels: the mean of those and one more.
        walks: from where the last frame was, so that this one may build on it; else the same settings and camera give
        the same picture, whatever was rendered before. A frame with a wanted error that is seen to have too large a one
        is tried again, and the last try is the picture.
        """
        if self._targeted is None:
            return self._render(camera, accumulation, walks)
        moves = self._targeted.governs_apart(walks=walks)
        settles = moves not in self._settled
        for number in range(SETTLING_FRAMES if settles else 0):
            self._shown = None  # one more of the same
            frame = self._render(_swayed(camera, number) if moves else camera, None, walks)
            self._progress("choosing counts of clusters", number / SETTLING_FRAMES)
            if self._learn(frame, shown=False):
                break
        self._settled.add(moves)
        frame = self._render(camera, accumulation, walks)
        # A camera that comes back from swaying sees more that is new than one that walks.
        jumps = settles and moves
        if frame.stats.counts["frames"] > 1 or frame.stats.skips["unchanged_camera"] or jumps:
            return frame
        self._learn(frame)
        for tries in range(1, MOST_TRIES):
            if not self._targeted.tries_again(tries):
                break
            if accumulation:
                accumulation.restart()
            self._shown = None
            better = self._render(camera, accumulation, walks)
            self._learn(better)
            frame = replace(better, stats=better.stats.after(frame.stats))
        return frame

    def _learn(self, frame: Frame, *, shown: bool = True) -> bool:
        """Whether counts can stay. What a frame takes is all that the host waits for, and learning of the last one."""
        begun = perf_counter()
        times = {**frame.stats.stage_ms, "host": median(self._host_ms[self._walked])}
        targeted, steady = self._targeted, self._stages.steady
        stays = targeted is not None and targeted.learn(times, steady=steady, shown=shown)
        self._learning_ms = 1e3 * (perf_counter() - begun)
        return stays

    def _render(self, camera: Camera, accumulation: Accumulation | None, walks: bool) -> Frame:
        begun = perf_counter()
        view, tonemap, exposure = self._view, self._tonemap, self._settings.exposure
        sample = accumulation.samples if accumulation else 0
        self._stages.start_frame()
        view_key = camera.view_key, sample
        # What a walk shows may depend on how it came there.
        kept = self._settings.skip.unchanged_camera and view_key == self._shown and (walks or not self._walked)
        if not kept:
            self._shown = None
            view.look(camera, sample, walks=walks)
            self._method.render(self._stages, sample, self._progress)
        radiance = view.radiance
        if accumulation:
            accumulation.add(radiance)
            radiance = accumulation.mean
        self._stages.run("display", lambda: tonemap.run(radiance, exposure), repeats=accumulation is None)
        if not kept:
            self._stages.follow(self._method.count)
        wp.synchronize_device(view.device)
        if not kept:
            self._statistics = self._method.statistics()
            self._shown, self._walked = view_key, walks
        counts, skips = self._statistics
        if kept:
            skips = {"unchanged_camera": view.pixels}
        counts = {"pixels": view.pixels, "frames": sample + 1, **counts, "nonfinite": tonemap.nonfinite()}
        skips = dict.fromkeys(Skips.model_fields, 0) | skips
        estimates = self._targeted.estimates() if self._targeted else {}
        stats = FrameStats(self._stages.milliseconds(), counts, skips, estimates)
        if self._stages.steady and not self._stages.captured and not kept and sample == 0:
            host_ms = 1e3 * (perf_counter() - begun) - sum(stats.stage_ms.values())
            self._host_ms[walks].append(max(host_ms, 0.0) + self._learning_ms)
        self._learning_ms = 0.0
        return Frame(view.size, radiance, tonemap.pixels, stats)
