"""What a renderer knows of a method: what it is made with, and what it does once a frame."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar

import warp as wp

from gpu.core.stages import Stages
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.direct.light_selection import SELECTION_PIXEL_BYTES
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts, bounces_of
from gpu.scene.types import Camera
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets, Progress

# What a frame is made of and what it did not have to do: counts by name; see gpu.film.frame.FrameStats.
FrameStatistics = tuple[dict[str, int], dict[str, int]]
# One frame from a camera, into an accumulation if there is one.
RenderOnce = Callable[[Camera, Accumulation | None], Frame]
View = TypeVar("View", bound=ViewState)


@dataclass(frozen=True)
class RenderSetup:
    """What pictures of one size of a scene are rendered with; light_sets: of that scene; progress: of long work."""

    device_scene: DeviceScene
    light_sets: LightSets
    size: tuple[int, int]
    settings: RenderSettings
    sample_counts: SampleCounts
    progress: Progress

    @property
    def device(self) -> wp.Device:
        """Where all arrays are."""
        return self.device_scene.device

    @property
    def pixels(self) -> int:
        """Of a picture."""
        return self.size[0] * self.size[1]

    @property
    def bounces(self) -> int:
        """Of indirect light, at most."""
        return bounces_of(self.settings, self.device_scene.own_features(lambertian=self.settings.lambertian))


class RenderMethod(ABC, Generic[View]):
    """Orders the stages of a frame. What it allocates has the setup's size and serves all viewers of it in turn.

    stage_names: those that a frame may have, in their order; pixel_bytes, view_pixel_bytes: device memory that it takes
    for each pixel of a size, and for each pixel of each viewer of that size; soft_view_pixel_bytes: that much more for
    the latter where the scene has soft light; lamps_pixel_bytes, specular_pixel_bytes, gloss_pixel_bytes,
    gloss_view_pixel_bytes, branches_pixel_bytes, caustic_pixel_bytes, tint_pixel_bytes: more where it has several
    lamps, chains, gloss and frosted glass, what chains may branch at, caustics, or part glass; caustic_photon_bytes: of
    each light path of caustics.
    """

    stage_names: ClassVar[tuple[str, ...]]
    pixel_bytes: ClassVar[int]
    view_pixel_bytes: ClassVar[int]
    soft_view_pixel_bytes: ClassVar[int] = 0
    lamps_pixel_bytes: ClassVar[int] = SELECTION_PIXEL_BYTES
    specular_pixel_bytes: ClassVar[int] = 12
    gloss_pixel_bytes: ClassVar[int] = 0
    gloss_view_pixel_bytes: ClassVar[int] = 0
    branches_pixel_bytes: ClassVar[int] = 0
    caustic_pixel_bytes: ClassVar[int] = 16
    tint_pixel_bytes: ClassVar[int] = 0
    caustic_photon_bytes: ClassVar[int] = 420

    @abstractmethod
    def __init__(self, setup: RenderSetup) -> None:
        """Allocate all that frames need, and make the lights that there are not yet."""

    @classmethod
    def bytes_a_pixel(cls, has: SceneFeatures) -> tuple[int, int]:
        """Device memory [bytes] for each pixel of a size, and of each viewer, in scenes of these features."""
        chains = has.see_through or (has.lobes and cls.gloss_pixel_bytes > 0)
        shared = cls.pixel_bytes + cls.specular_pixel_bytes * chains + cls.gloss_pixel_bytes * has.lobes
        shared += cls.lamps_pixel_bytes * has.lamps + cls.caustic_pixel_bytes * has.caustics
        shared += cls.branches_pixel_bytes * has.see_through + 16 * has.sheen + 12 * (has.grain + has.translucent)
        shared += cls.tint_pixel_bytes * has.part_glass
        view = cls.soft_view_pixel_bytes * has.soft + cls.gloss_view_pixel_bytes * has.lobes
        return shared, cls.view_pixel_bytes + view

    @classmethod
    def caustic_bytes(cls, has: SceneFeatures, sample_counts: SampleCounts) -> int:
        """Device memory [bytes] that caustics take of a scene of these features."""
        return cls.caustic_photon_bytes * sample_counts.caustic_photons * has.caustics

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """Device memory [bytes] that these counts of clusters take in all, and for each viewer."""
        return 0, 0

    @abstractmethod
    def new_view(self) -> View:
        """What a new viewer's walk leaves behind from now on; nothing yet."""

    @abstractmethod
    def render(self, view: View, stages: Stages, sample: int) -> None:
        """Fill the view's radiance for its camera.

        sample: the frame's number among those of a still view; each has its own samples.
        """

    def weight(self, sample: int) -> float:
        """What frame `sample` of a still view counts for in the mean of them all."""
        return 1.0

    def count(self, view: View) -> None:
        """Launch the sums that `statistics` reads."""

    @abstractmethod
    def statistics(self, view: View) -> FrameStatistics:
        """Of the view's last frame, once it is ready and `count` has run."""

    def estimates(self, view: View) -> dict[str, float]:
        """What was expected of the view's last frame, by name, where something was wanted of it."""
        return {}

    def show(
        self, once: RenderOnce, view: View, camera: Camera, accumulation: Accumulation | None, *, walks: bool
    ) -> Frame:
        """The frame that is shown of `camera`, of one or more that `once` renders; walks: as for `Renderer.render`."""
        return once(camera, accumulation)
