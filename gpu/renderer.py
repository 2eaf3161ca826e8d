"""A renderer: one image size and one choice of settings of a scene, for any number of viewers in turn."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import partial
from math import inf
from weakref import finalize

import warp as wp

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame, FrameStats
from gpu.film.tonemap import Tonemap
from gpu.methods.method import RenderSetup
from gpu.methods.registry import make_method
from gpu.methods.view_state import ViewState
from gpu.sample_counts import sample_counts_of
from gpu.scene.types import Camera
from gpu.settings import RenderSettings, Skips
from gpu.vpl.light_sets import LightSets, Progress

MAX_SIDE = 16_384
# Of a GPU's frame: while frames take longer, and others want the device, they may have it between its stages.
LONG_FRAME_SECONDS = 0.03
NOTHING_SKIPPED = dict.fromkeys(Skips.model_fields, 0)
REMEMBERED = 0.8  # of a long frame's time, by the next one, which may be shorter than those to come


@dataclass(frozen=True)
class _Launched:
    """A frame on its way: what it shows, as what; unchanged: it is the view's last one."""

    radiance: wp.array
    shown: Hashable
    sample: int
    walks: bool
    unchanged: bool


def _silent(what: str, fraction: float) -> None:
    """Report progress to nobody."""


class Renderer:
    """Renders a scene at `size` (width, height) with `settings`; its arrays are allocated once.

    light_sets: the scene's, where several renderers share them; else they are the renderer's own. lane: where frames
    run, beside those of renderers in other lanes (gpu.core.lane); None: one of its own. downloads: whether each frame
    comes with its pixels on the host, which Frame.pixels would wait for.
    progress(what, fraction) is called during long work, the first time light is traced above all.
    Raises UserError when a side of `size` is not within 1 … 16384 pixels.
    """

    def __init__(
        self,
        device_scene: DeviceScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress | None = None,
        light_sets: LightSets | None = None,
        lane: Lane | None = None,
        *,
        downloads: bool = False,
    ) -> None:
        if not all(1 <= side <= MAX_SIDE for side in size):
            raise UserError(f"size: each side must be 1 to {MAX_SIDE} pixels, got {size[0]}x{size[1]}")
        self._size, self._settings, self._device = size, settings, device_scene.device
        self._pixels = size[0] * size[1]
        self._lane = lane or Lane(self._device)
        self._stages = Stages(self._device, self._lane)
        self._tonemap = Tonemap(self._pixels, self._device)
        self._display, self._downloads = StagingBuffer(self._tonemap.pixels), downloads
        DEVICE_SHARING.pause()
        self._light_sets = light_sets or LightSets(device_scene)
        counts = sample_counts_of(settings, self._device, self._pixels)
        setup = RenderSetup(device_scene, self._light_sets, size, settings, counts, progress or _silent)
        self._method = make_method(setup)
        self._own_view: ViewState | None = None
        self._long_seconds = inf  # of the last frames; the first loads kernels

    def new_view(self) -> ViewState:
        """What a new viewer's walk leaves behind from frame to frame; freed with the last reference to it."""
        view = self._method.new_view()
        view.version, view.surface_version = self._light_sets.version, self._light_sets.surface_version
        finalize(view, self._stages.forget, view.number)
        return view

    def render(
        self,
        camera: Camera,
        accumulation: Accumulation | None = None,
        *,
        view: ViewState | None = None,
        walks: bool = False,
    ) -> Frame:
        """The picture from `camera`, ready when the call returns.

        With an `accumulation`, of this camera's earlier frames and as many pixels: the mean of those and one more.
        view: the viewer's, of `new_view`; without one, the renderer's own. walks: from where the view's last frame was,
        so that this one may build on it; else the same settings and camera give the same picture, whatever was rendered
        before. What other viewers render in between changes nothing. Where the device is shared (gpu.core.sharing) a
        long frame gives it to others, and others have the host while a short one is on the device; this renderer must
        not be used by them until it is done. A frame for a wanted time is alone on the device, since it is timed.
        """
        if view is None:
            view = self._own_view = self._own_view or self.new_view()
        once = partial(self._render, view, walks)
        return self._method.show(once, view, camera, accumulation, walks=walks)

    def _render(self, view: ViewState, walks: bool, camera: Camera, accumulation: Accumulation | None) -> Frame:
        stages, begun = self._stages, DEVICE_SHARING.own_time()
        if self._device.is_cuda:
            stages.stepwise = DEVICE_SHARING.active and self._long_seconds > LONG_FRAME_SECONDS
        if self._settings.target_ms is not None:
            wp.synchronize_device(self._device)
        if stages.stepwise:
            launched = self._launch(view, walks, camera, accumulation)
            wp.synchronize_device(self._device)
        else:
            with DEVICE_SHARING.keep(), self._lane.entered():
                launched = self._launch(view, walks, camera, accumulation)
        took, beside = DEVICE_SHARING.own_time() - begun, self._wait()
        frame = self._finish(view, launched, begun)
        if stages.steady and not stages.captured:
            # Frames that were on the device at once took about as long as one after the other.
            took += 0.0 if stages.stepwise else 1e-3 * sum(frame.stats.stage_ms.values()) / beside
            before = 0.0 if self._long_seconds == inf else REMEMBERED * self._long_seconds
            self._long_seconds = max(took, before)
        return frame

    def _wait(self) -> int:
        """Wait for what was launched, and leave the host to others; how many frames were on the device at once."""
        flight, beside = self._lane.flight(), 1 + DEVICE_SHARING.in_flight
        if self._settings.target_ms is None:
            DEVICE_SHARING.leave_until(flight.is_over)
        flight.wait()
        return max(beside, 1 + DEVICE_SHARING.in_flight)

    def _launch(self, view: ViewState, walks: bool, camera: Camera, accumulation: Accumulation | None) -> "_Launched":
        stages, sample = self._stages, accumulation.samples if accumulation else 0
        if view.version != self._light_sets.version:
            if view.surface_version == self._light_sets.surface_version:
                view.forget_light()
            else:
                view.forget()
            view.version, view.surface_version = self._light_sets.version, self._light_sets.surface_version
        shown = camera.view_key, sample
        # What a walk shows may depend on how it came there.
        unchanged = self._settings.skip.unchanged_camera and shown == view.shown and (walks or not view.walked)
        stages.start_frame()
        stages.graph_key = (view.number,)
        if not unchanged:
            view.shown = None
            view.set_camera(camera, sample, walks=walks, stages=stages)
            self._method.render(view, stages, sample)
        radiance = view.radiance
        if accumulation:
            stages.flush()
            accumulation.add(radiance, self._method.weight(sample))
            radiance = accumulation.mean

        def display() -> None:
            self._tonemap.run(radiance, self._settings.exposure)
            if self._downloads:
                self._display.download()

        stages.run("display", display, repeats=accumulation is None)
        if not unchanged:
            stages.run_untimed(partial(self._method.count, view))
        stages.flush()
        self._light_sets.settle()
        return _Launched(radiance, shown, sample, walks=walks, unchanged=unchanged)

    def _finish(self, view: ViewState, launched: "_Launched", begun: float) -> Frame:
        """The frame that was launched, once it is ready; begun: when it was, on the clock of its own time [s]."""
        stages, unchanged, sample = self._stages, launched.unchanged, launched.sample
        if not unchanged:
            view.statistics = self._method.statistics(view)
            view.shown, view.walked = launched.shown, launched.walks
        counts, skips = view.statistics
        if unchanged:
            skips = {"unchanged_camera": self._pixels}
        own = {"pixels": self._pixels, "frames": sample + 1}
        stage_ms, host_ms = stages.milliseconds(), None
        if stages.steady and not stages.captured and not unchanged and sample == 0:
            host_ms = max(1e3 * (DEVICE_SHARING.own_time() - begun) - sum(stage_ms.values()), 0.0)
        stats = FrameStats(
            stage_ms,
            own | counts | {"nonfinite": self._tonemap.nonfinite()},
            NOTHING_SKIPPED | skips,
            self._method.estimates(view),
            steady=stages.steady,
            host_ms=host_ms,
        )
        return Frame(self._size, launched.radiance, self._display, stats, None if self._downloads else self._lane)
