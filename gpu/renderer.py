"""A renderer: one image size and one choice of settings of a resident scene, one frame after the other."""

import warp as wp

from gpu.accumulate import Accumulation, pixel_place
from gpu.errors import UserError
from gpu.frame import Frame, FrameStats
from gpu.interpolate import STRIDE
from gpu.lighting import Progress, lighting_of
from gpu.methods.common import RenderMethod
from gpu.methods.exact_vpl import ExactVpl
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.path import PathTracing
from gpu.quality import quality_of
from gpu.resident import ResidentScene
from gpu.scene.types import Camera
from gpu.settings import Clustering, Method, RenderSettings
from gpu.stages import Stages
from gpu.tonemap import Tonemap
from gpu.view import View

MAX_SIDE = 16_384


def _silent(what: str, fraction: float) -> None:
    """Report progress to nobody."""


class Renderer:
    """Renders `resident` at `size` (width, height) with `settings`; its arrays are allocated once.

    progress(what, fraction) is called during long work, the first time light is traced above all.
    Raises UserError when a side of `size` is not within 1 … 16384 pixels.
    """

    def __init__(
        self,
        resident: ResidentScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress | None = None,
    ) -> None:
        if not all(1 <= side <= MAX_SIDE for side in size):
            raise UserError(f"size: each side must be 1 to {MAX_SIDE} pixels, got {size[0]}x{size[1]}")
        self._progress = progress or _silent
        self._settings = settings
        stride = STRIDE if settings.interpolate and self._is_fuzzy() else 1
        self._view = View(resident, size, lambertian=settings.lambertian, stride=stride)
        self._stages = Stages(resident.device)
        self._tonemap = Tonemap(self._view.pixels, resident.device)
        self._method = self._make_method(resident)

    def _is_fuzzy(self) -> bool:
        return self._settings.method is Method.FUZZY_VPL and self._settings.clustering is not Clustering.VPLS

    def _make_method(self, resident: ResidentScene) -> RenderMethod:
        settings = self._settings
        method = PathTracing if settings.method is Method.PATH else FuzzyVpl if self._is_fuzzy() else ExactVpl
        quality = quality_of(settings, resident.device)
        return method(self._view, settings, quality, lighting_of(resident), self._progress)

    def render(self, camera: Camera, accumulation: Accumulation | None = None) -> Frame:
        """The picture from `camera`, ready when the call returns.

        With an `accumulation`, of this camera's earlier frames and as many pixels: the mean of those and one more.
        """
        view, tonemap, exposure = self._view, self._tonemap, self._settings.exposure
        sample = accumulation.samples if accumulation else 0
        self._stages.start_frame()
        view.look(camera, pixel_place(sample))
        self._method.render(self._stages, sample, self._progress)
        radiance = view.radiance
        if accumulation:
            accumulation.add(radiance)
            radiance = accumulation.mean
        self._stages.run("display", lambda: tonemap.run(radiance, exposure), repeats=accumulation is None)
        wp.synchronize_device(view.device)
        counts, skips = self._method.statistics()
        nonfinite = int(tonemap.nonfinite.numpy()[0])
        counts = {"pixels": view.pixels, "frames": sample + 1, **counts, "nonfinite": nonfinite}
        stats = FrameStats(self._stages.milliseconds(), counts, skips)
        return Frame(view.size, radiance, tonemap.pixels, stats)
