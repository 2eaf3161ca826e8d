"""`path`: path tracing, the reference for the whole error of the other methods."""

from gpu.core.stages import Stages
from gpu.direct.path_tracing import trace_paths
from gpu.methods.passes import FrameStatistics, frame_seed
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets, Progress

# Paths a launch: a fraction of a second on a GPU, and often enough for progress on a CPU.
PATHS_PER_LAUNCH = 1 << 25
PATHS_PER_CPU_LAUNCH = 1 << 19


class PathTracing:
    """Camera paths with direct light sampled at every bounce (Kajiya 1986), `samples` of them a pixel."""

    def __init__(
        self,
        view: ViewState,
        settings: RenderSettings,
        sample_counts: SampleCounts,
        light_sets: LightSets,
        progress: Progress,
    ) -> None:
        self._view, self._settings, self._samples, self._table = view, settings, sample_counts.samples, light_sets.table
        progress("path tracing needs no virtual point lights", 1.0)

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """Average all samples, some a launch."""
        stages.run("paths", lambda: self._trace(frame_seed(self._settings.seed, sample), progress), repeats=False)

    def _trace(self, seed: int, progress: Progress) -> None:
        view, settings = self._view, self._settings
        paths = PATHS_PER_LAUNCH if view.device.is_cuda else PATHS_PER_CPU_LAUNCH
        run = max(1, paths // view.pixels)
        for first in range(0, self._samples, run):
            samples = min(run, self._samples - first)
            trace_paths(
                view.device_scene,
                view.scene,
                self._table,
                view.camera,
                view.size,
                settings.component,
                settings.bounces,
                first,
                samples,
                seed,
                view.radiance,
            )
            progress("tracing paths", (first + samples) / self._samples)

    def count(self) -> None:
        """Nothing is counted."""

    def statistics(self) -> FrameStatistics:
        """Camera paths a pixel; nothing is skipped in a reference."""
        return {"samples": self._samples}, {}
