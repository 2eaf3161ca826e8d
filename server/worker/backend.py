"""What renders in a worker process: the only part of the service that imports Warp.

Scenes and renderers are shared by all viewers of them. What is kept for a viewer is the mean of its still view's
frames, and what its walk leaves behind. A scene that nobody looks at is dropped for another once `max_scenes` are
loaded, the least recently used first.
"""

import ctypes
import logging
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from threading import Thread
from time import monotonic, perf_counter
from typing import TypeVar

import warp as wp

from gpu.core.device import choose_device
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.features import SceneFeatures
from gpu.errors import OutOfMemoryError, UserError
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.sample_counts import sample_counts_of
from gpu.scene.builtin import MADE_AT_ONCE
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.formats.gltf.writing import glb_of
from gpu.scene.lighting.environment import with_environment
from gpu.scene.load import load_scene
from gpu.scene.types import Scene
from gpu.settings import RenderSettings
from gpu.warm_up import load_kept_kernels, warm_up_soon
from server.scenes.scene_info import describe_scene
from server.scenes.view_camera import view_camera
from server.wire.browser import PickedPart, SceneInfo
from server.wire.worker import MAX_EXPORT_BYTES, STILLS, CameraSpec, Export, Pick, Render, SceneCamera, SceneRef, Start
from server.worker import warm_ahead
from server.worker.device_encode import DeviceEncoder, device_encoder
from server.worker.kernel_cache import check_kernel_cache, needs_kernel_cache
from server.worker.late_edits import COMPILING, LateEdits
from server.worker.loaded_scene import LoadedScene, build, edit, with_kernels
from server.worker.memory import free_host_bytes, own_bytes
from server.worker.picking import picked_part
from server.worker.renderer_pool import RendererPool, lasting
from server.worker.scene_reading import SceneReading, read_beside
from server.worker.scene_states import SceneStates
from server.worker.tasks import Tasks
from server.worker.worker import Picture, Report

FIRST_SIZE = (64, 36)
# What a job has at least of a turn that others wait for: half of what they may have to wait.
CUDA_TURN_SECONDS, CPU_TURN_SECONDS = 0.025, 0.25
MEMORY_SECONDS = 0.5
# How Warp says that the device has no memory left.
NO_MEMORY = re.compile(r"[Ff]ailed to allocate|out of memory")
Result = TypeVar("Result")
log = logging.getLogger("lumenwalk.renderer")


@dataclass
class _Still:
    """What a viewer looks at, and the mean of the frames of it so far."""

    view: tuple[SceneRef, CameraSpec, tuple[int, int], RenderSettings, SceneEdits]
    accumulation: Accumulation


class GpuBackend:
    """Renders with gpu/ on one device."""

    def __init__(self, served: SceneReading | None = None) -> None:
        """served: the scene that it starts with, if that is being read already."""
        self._start, self._served = Start(SceneRef("", "")), served
        self._device: wp.Device = None
        self._scenes: dict[SceneRef, LoadedScene] = {}  # in the order of their last use
        self._states = SceneStates(lambda state: self._renderers.drop_state(state))
        self._warm: set[SceneFeatures] = set()  # whose kernels were loaded for scenes with edits
        self._late_edits = LateEdits()
        self._viewed: dict[int, SceneRef] = {}  # by viewer
        self._stills: dict[int, _Still] = {}  # by viewer
        self._encoder: DeviceEncoder | None = None
        self._memory_all, self._memory_free, self._memory_asked = 0, 0, 0.0

    @property
    def lanes(self) -> int:
        """How many pictures may be on the device at once."""
        return self._renderers.frames

    def start(self, start: Start, report: Report, tasks: Tasks) -> str:
        """Choose a device, load the served scene, render one frame of it; return the device's name."""
        self._start = start
        with needs_kernel_cache():
            self._device = choose_device(start.device)
        check_kernel_cache(wp.config.kernel_cache_dir)
        tasks.turn_seconds = CUDA_TURN_SECONDS if self._device.is_cuda else CPU_TURN_SECONDS
        self._encoder = device_encoder(self._device)
        self._renderers = RendererPool(self._device, downloads=self._encoder is None)
        # While the scene is read.
        Thread(target=load_kept_kernels, args=(self._device,), name="kernels", daemon=True).start()
        self.render(Render(STILLS, start.scene, SceneCamera(0), FIRST_SIZE, RenderSettings(), "none"), report)
        self._ahead = warm_ahead.begin(self._device)
        return f"{self._device.name} ({self._device})" if self._device.is_cuda else str(self._device)

    def open(self, scene: SceneRef, report: Report, packed: str = "") -> SceneInfo:
        """Make sure that a scene, `packed` where it was read already, is on the device; OutOfMemoryError when that
        cannot hold it.
        """
        what = f"{scene.id}: the device has too little memory for this scene; close others, or simplify it"
        loaded = self._with_room(lambda: self._load(scene, report, packed), what)
        return describe_scene(scene.id, loaded.scene, scene.options)

    def beside(self, scene: SceneRef) -> dict[str, int]:
        """Files that a scene, which is loaded, was read with."""
        return dict(self._scenes[scene].scene.report.beside)

    def close(self, scene: SceneRef) -> None:
        """Free a scene and all that was made for it."""
        self._scenes.pop(scene, None)
        self._states.close(scene)
        self._renderers.drop(scene)
        for viewer in [viewer for viewer, viewed in self._viewed.items() if viewed == scene]:
            self.leave(viewer)
        if not self._device.is_cuda and hasattr(libc := ctypes.CDLL(None), "malloc_trim"):
            libc.malloc_trim(0)  # glibc would keep hundreds of megabytes

    def scenes(self) -> tuple[SceneRef, ...]:
        """What is on the device, the longest unused first."""
        return tuple(self._scenes)

    def render(self, job: Render, report: Report) -> Picture:
        """Render one picture; OutOfMemoryError when the device cannot hold what that takes."""
        what = (
            f"the device has too little memory for {job.size[0]}×{job.size[1]} pixels with these settings; "
            "ask for a smaller size, or for fewer clusters or VPLs"
        )
        return self._with_room(lambda: self._picture(job, report), what)

    def pick(self, job: Pick, report: Report) -> PickedPart:
        """Say what a camera sees at one point of its picture, of the scene as it is edited."""
        what = f"{job.scene.id}: the device has too little memory for this scene; close others, or simplify it"
        return self._with_room(lambda: self._picked(job, report), what)

    def export(self, job: Export, report: Report) -> bytes:
        """Write a scene, as it is edited, as a GLB file, while others have the device."""
        what = f"{job.scene.id}: the device has too little memory for this scene; close others, or simplify it"
        scene = self._with_room(lambda: self._load(job.scene, report), what).scene
        report(f"writing {job.scene.id}", 0.5)
        file = DEVICE_SHARING.beside(lambda: glb_of(edited(scene, job.edits)))
        if len(file) > MAX_EXPORT_BYTES:
            megabytes = f"{len(file) / 1e6:,.0f} MB, more than the {MAX_EXPORT_BYTES / 1e6:,.0f}"
            raise UserError(f"{job.scene.id}: as a GLB file has {megabytes} that are given out")
        return file

    def leave(self, viewer: int) -> None:
        """Free what is kept for a viewer."""
        self._viewed.pop(viewer, None)
        self._stills.pop(viewer, None)
        self._states.leave(viewer)
        self._late_edits.leave(viewer)
        self._renderers.leave(viewer)

    def memory(self) -> tuple[int, int]:
        """Bytes of the device in use, and all that it has; on a CPU, what this process has and what it may have."""
        # Asking the driver, or the system, costs as much as a small stage, and this is asked after every frame.
        if monotonic() - self._memory_asked > MEMORY_SECONDS:
            self._memory_asked = monotonic()
            self._memory_free = self._device.free_memory if self._device.is_cuda else free_host_bytes()
            self._memory_all = self._device.total_memory if self._device.is_cuda else 0
        if self._device.is_cuda:
            return self._memory_all - self._memory_free, self._memory_all
        used = own_bytes()
        return used, used + self._memory_free

    def healthy(self) -> bool:
        """Whether the device still answers."""
        try:
            wp.synchronize_device(self._device)
        except Exception:
            return False
        return True

    def _load(self, ref: SceneRef, report: Report, packed: str = "") -> LoadedScene:
        with DEVICE_SHARING.holding(ref):
            return self._loaded(ref, report, packed)

    def _loaded(self, ref: SceneRef, report: Report, packed: str = "") -> LoadedScene:
        self._take_late_kernels(ref)
        loaded = self._scenes.pop(ref, None)
        if loaded is None:
            self._make_room()
            report(f"reading {ref.id}", 0.0)
            scene = with_environment(self._read(ref, packed), self._start.environment)
            scene = replace(scene, name=ref.id)  # all that viewers know
            report(f"building {ref.id}", 0.5)
            loaded = build(ref, scene, self._device)
            report(COMPILING, 0.8)
            if late := warm_up_soon(loaded.device_scene, RenderSettings()):
                loaded = with_kernels(loaded, late)
        self._scenes[ref] = loaded
        return loaded

    def _read(self, ref: SceneRef, packed: str) -> Scene:
        if ref.source in MADE_AT_ONCE:
            return load_scene(ref.source, options=ref.options)
        served, self._served = self._served, None
        if served is not None and served.ref == ref:
            return served.scene()
        return read_beside(ref, self._start, packed)

    def _take_late_kernels(self, ref: SceneRef) -> None:
        """Have a scene shown by its own kernels from its next frame on, once they are compiled."""
        loaded = self._scenes.get(ref)
        if loaded is not None and self._late_are_there(loaded) and ref in self._scenes:
            self._scenes[ref] = with_kernels(loaded, None)
            self._states.close(ref)
            self._renderers.drop(ref)
        self._states.renew(ref, self._late_are_there)

    def _late_are_there(self, loaded: LoadedScene) -> bool:
        """Whether a scene is shown by general kernels while its own have been compiled, and are loaded now."""
        if loaded.late is None or not loaded.late.compiled:
            return False
        try:
            loaded.late.load()
        except Exception:  # what Warp raises where a compiler fails
            log.exception("%s: its kernels cannot be compiled, general ones go on", loaded.ref.id)
            loaded.late = None
            return False
        return True

    @contextmanager
    def _state(
        self, ref: SceneRef, edits: SceneEdits, viewer: int, report: Report, *, own: bool = False, walks: bool = False
    ) -> Iterator[LoadedScene]:
        """A scene with `edits`, as long as something is rendered of it for a viewer, who may walk; own: which nobody
        else sees.
        """
        with ExitStack() as used:
            if edits == NO_EDITS:
                self._late_edits.leave(viewer)
            else:
                with DEVICE_SHARING.holding(ref):
                    loaded = self._loaded(ref, report)
                edits = self._late_edits.to_show(loaded, edits, viewer, report, walks=walks)
            with DEVICE_SHARING.holding(ref):
                loaded = self._loaded(ref, report)
                if edits == NO_EDITS:
                    self._states.leave(viewer)
                else:
                    make = partial(self._edited, loaded, edits, report)
                    loaded = used.enter_context(self._states.using(ref, edits, viewer, make, own=own))
            yield loaded

    def _edited(
        self, loaded: LoadedScene, edits: SceneEdits, report: Report, before: LoadedScene | None
    ) -> LoadedScene:
        state = edit(loaded, edits, before)
        if state is before:
            return state
        features = state.device_scene.own_features(lambertian=False)
        if features == loaded.device_scene.own_features(lambertian=False):
            goes_on = state.device_scene.general == loaded.device_scene.general
            return state if goes_on else with_kernels(state, loaded.late)
        late = None
        if features not in self._warm:
            report(COMPILING, 0.8)
            late = warm_up_soon(state.device_scene.generalised(general=False), RenderSettings())
        if late is None:
            self._warm.add(features)
        return with_kernels(state, late) if late or state.device_scene.general else state

    def _make_room(self) -> None:
        while len(self._scenes) >= self._start.max_scenes:
            used = set(self._viewed.values())
            idle = next((ref for ref in self._scenes if ref not in used), None)
            if idle is None:
                raise UserError(
                    f"{len(used)} scenes are being viewed, as many as this server keeps; choose one of those"
                )
            self.close(idle)

    def _with_room(self, work: Callable[[], Result], what: str) -> Result:
        """The result of `work`, tried again once what can be made anew is freed; then OutOfMemoryError of `what`."""
        refusal = OutOfMemoryError(what)
        for _ in range(2):
            try:
                return work()
            except OutOfMemoryError as error:  # before it was tried
                refusal = error
            except RuntimeError as error:
                if not NO_MEMORY.search(str(error)):
                    raise
            self._renderers.clear()
            self._states.clear()
            self._stills.clear()
        raise refusal

    def _picked(self, job: Pick, report: Report) -> PickedPart:
        with self._state(job.scene, job.edits, STILLS, report) as state:
            camera = view_camera(state.scene, job.view, job.size)
            return picked_part(self._scenes[job.scene].scene, state.device_scene, camera, job.place)

    def _picture(self, job: Render, report: Report) -> Picture:
        with self._state(job.scene, job.edits, job.viewer, report, own=job.own, walks=job.walks) as loaded:
            # Frames of one viewer follow one another, and so do those of one renderer, whose arrays they share.
            who = ("viewer", job.viewer) if job.viewer > STILLS else ("request", job.request)
            lane = self._renderers.lane_of(job.viewer)
            renderer = job.scene, loaded.number, job.size, lasting(job.settings), lane
            with DEVICE_SHARING.holding(who), DEVICE_SHARING.holding(renderer):
                return self._frame(job, lane, loaded, report)

    def _frame(self, job: Render, lane: int, loaded: LoadedScene, report: Report) -> Picture:
        camera = view_camera(loaded.scene, job.view, job.size)
        if job.viewer > STILLS:
            self._viewed[job.viewer] = job.scene
        what = job.viewer, lane, loaded, job.size, job.settings
        if (found := self._renderers.find(*what)) is None:
            with DEVICE_SHARING.holding(("lights", loaded.number)):  # that a first renderer makes for all lanes
                found = self._renderers.get(*what, report)
        renderer, view = found
        try:
            frame = renderer.render(camera, self._accumulation(job, loaded), view=view, walks=job.walks)
        except BaseException:
            self._renderers.discard(renderer)  # what it and the mean hold after an error is not known
            self._stills.pop(job.viewer, None)
            raise
        return self._result(job, frame)

    def _accumulation(self, job: Render, loaded: LoadedScene) -> Accumulation | None:
        """The mean that the frame goes into, started anew where it is not that of the frames before."""
        if job.sample is None:
            return None
        view = (job.scene, job.view, job.size, job.settings, loaded.edits)
        still = self._stills.get(job.viewer)
        if still is None or len(still.accumulation.mean) != job.size[0] * job.size[1]:
            self._stills.pop(job.viewer, None)  # before the new one takes memory
            still = self._stills[job.viewer] = _Still(view, Accumulation(job.size[0] * job.size[1], self._device))
        if still.view != view or still.accumulation.samples != job.sample:
            still.view = view
            still.accumulation.restart()
        return still.accumulation

    def _result(self, job: Render, frame: Frame) -> Picture:
        pixels, radiance, image, encode_ms = None, None, None, 0.0
        if job.output == "jpeg" and self._encoder is not None:
            began = perf_counter()
            image = self._encoder.encode(frame.device_pixels, frame.size, job.quality)
            encode_ms = 1e3 * (perf_counter() - began)
        elif job.output in (".exr", ".npy"):
            radiance = frame.radiance()
        elif job.output != "none":
            pixels = frame.pixels()
        samples, target = frame.stats.counts["frames"], sample_counts_of(job.settings, self._device).frames
        stats = (frame.stats.stage_ms, frame.stats.counts, frame.stats.skips, frame.stats.estimates)
        return Picture(samples, target, image, encode_ms, pixels, radiance, *stats)
