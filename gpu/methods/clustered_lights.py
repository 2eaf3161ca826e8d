"""What frames of clustered VPLs and SPs need of their lights, wherever these come from."""

from abc import ABC, abstractmethod
from typing import Any

from gpu.core.stages import Stages, new_number
from gpu.indirect.clustered_light import clustered_light
from gpu.indirect.far_field import FarSums
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.visibility import Visibility
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind
from gpu.methods.fuzzy_correction import Convergence, FuzzyCorrection
from gpu.methods.fuzzy_view_state import FuzzyViewState, KeptLight
from gpu.methods.method import RenderSetup
from gpu.vpl.vpl_clusters import VplClusters


class ClusteredLights(ABC):
    """VPL clusters that light a frame, and arrays that have room for as many.

    vpls: the clusters of the last frame's; cache: the radiosity around them (RadiosityCache), None where near-field
    light is not wanted; has_indirect: whether they light anything, or may, where `choose` is to make them; has_near:
    whether near-field light is wanted of them, too; are_kept: whether they were there before the frame; are_late:
    whether `choose` makes them beside SP clusters; relights: whether every frame has others; converges: whether the
    mean of a still view's later frames is what path tracing finds; number: of these arrays alone, for captured graphs;
    room: for SP clusters and VPL clusters; correction: what corrects their light, if `corrects`.
    """

    vpls: VplClusters
    cache: Any
    correction: FuzzyCorrection
    has_indirect: bool
    has_near: bool
    corrects: bool
    room: tuple[int, int]
    are_kept = True
    are_late = False
    relights = False
    converges = False

    def __init__(self, setup: RenderSetup, frame: FrameArrays) -> None:
        self._setup, self._frame, self.number = setup, frame, new_number()

    @property
    def numbers(self) -> tuple[int, ...]:
        """Of arrays that frames read, for captured graphs."""
        return (self.number,)

    @abstractmethod
    def follow(self, kind: FrameKind) -> bool:
        """Follow the scene's light into a frame that is about to begin; False where others must take their place."""

    @abstractmethod
    def choose(self, view: FuzzyViewState, kind: FrameKind, stages: Stages, *, begins: bool) -> None:
        """Have in `vpls` and `cache` those of a frame, whose G-buffer is filled; begins: a view keeps nothing of its
        last frame's lights.
        """

    @abstractmethod
    def reuses_clusters(self, view: FuzzyViewState, kept: KeptLight, kind: FrameKind) -> bool:
        """Whether the frame goes on with the SP clusters of the view's last one."""

    def convergence(self, kind: FrameKind) -> Convergence | None:
        """What a frame is lit by that is one of those whose mean is what path tracing finds; None for others."""
        return None

    def trace(self, view: FuzzyViewState) -> None:
        """Find which of the lights the new SP clusters of a view see."""
        self.known_to(view).visibility.trace(self._frame.scene, view.clustering.clusters, self.vpls)

    def shade(self, view: FuzzyViewState, *, few: bool) -> None:
        """Shade the SPs of a view by what its SP clusters see; few: whether most of these are kept."""
        frame, kept, clusters = self._frame, self.known_to(view), view.clustering.clusters
        kept.far.run(clusters, kept.visibility.words, self.vpls, few=few)
        known = clustered_light(clusters, kept.visibility.words, self.vpls, kept.far.data)
        shade(self._setup.settings.fuzziness, frame.gbuffer, view.points, known, frame.seed, frame.indirect)

    def known_to(self, view: FuzzyViewState) -> KeptLight:
        """What a view's representatives know of these lights."""
        if self not in view.lights:
            other = view.lights_of_others(self)
            view.lights[self] = other.for_another_viewer() if other else self._unknown()
        return view.lights[self]

    def _unknown(self) -> KeptLight:
        skip, device = self._setup.settings.skip, self._setup.device
        far = FarSums(*self.room, device, enabled=skip.far_field_sums)
        visibility = Visibility(
            *self.room, device, facing_away=skip.facing_away, shared_weak_rays=skip.shared_weak_rays
        )
        return KeptLight(visibility, far)

    def check_room(self, sp_clusters: int) -> None:
        """Raise ValueError where there is no room for so many SP clusters: they would write beyond arrays' ends."""
        if sp_clusters > self.room[0]:
            raise ValueError(f"{sp_clusters} SP clusters where there is room for {self.room[0]}")
