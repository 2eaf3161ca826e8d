"""The stage of caustics, which methods with a G-buffer share: photons aimed at mirrors, glass and gloss, gathered at
shading points.
"""

from dataclasses import dataclass
from functools import partial
from math import sqrt

import warp as wp

from gpu.core.reduce import Counter
from gpu.core.stages import Stages
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.caustics import CausticGather
from gpu.lights.caustic_casters import CausticCasters, caustic_casters
from gpu.lights.caustic_map import CausticLight, CausticMap
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind, frame_seed
from gpu.methods.method import RenderSetup
from gpu.methods.view_state import ViewState
from gpu.settings import Component


@dataclass(frozen=True)
class StillCausticParameters:
    """How estimates narrow over the frames of a still view, whose mean forgets how wide the first were.

    kept: of the growth of photons in a disk, frame by frame, that stays there, while the rest narrows it (C. Knaus and
    M. Zwicker, Progressive Photon Mapping: A Probabilistic Approach, 2011): with two thirds, error by width and noise
    fade alike.
    """

    kept: float = 2.0 / 3.0


STILL_CAUSTIC_PARAMETERS = StillCausticParameters()


def radius_share(sample: int) -> float:
    """How wide an estimate of frame `sample` of a still view is beside one of the first (Knaus and Zwicker, Eq. 20)."""
    square = 1.0
    for number in range(1, sample + 1):
        square *= (number + STILL_CAUSTIC_PARAMETERS.kept) / (number + 1)
    return sqrt(square)


def caustics_of(setup: RenderSetup, frame: FrameArrays) -> "Caustics | None":
    """Those of a scene that may have some, where more than direct light is wanted."""
    wanted = frame.features.caustics and setup.settings.component is not Component.DIRECT
    return Caustics(setup, frame) if wanted else None


class Caustics:
    """Caustics of frames of one size: by `begin`, `fill`, then `end`, beside the stages between. Photons are kept while
    the light does not change, but each frame of a still view has its own.
    """

    def __init__(self, setup: RenderSetup, frame: FrameArrays) -> None:
        self._setup, self._frame = setup, frame
        self._map = CausticMap(setup.sample_counts.caustic_photons, setup.bounces, setup.device)
        self._gather = CausticGather(setup.pixels, setup.device)
        self._casters: list[CausticCasters] = []
        self._version, self._traced = -1, (-1, -1)
        self._seed = wp.zeros(1, dtype=int, device=setup.device)
        self._counter = Counter(1, setup.device)

    def begin(self, points: ShadingPoints, kind: FrameKind, stages: Stages) -> None:
        """Begin to gather at the SPs of a picture whose G-buffer is filled, `points`."""
        sets = self._setup.light_sets
        if self._version != sets.version:
            self._casters, self._version = caustic_casters(self._setup.device_scene), sets.version
        wanted = sets.version, kind.sample
        if wanted != self._traced:
            self._traced = wanted
            self._seed.fill_(frame_seed(self._setup.settings.seed, kind.sample))
            self._map.light.share.fill_(radius_share(kind.sample))
            # Its launches are of casters that another light may have more of.
            stages.run("caustic-photons", self._trace, repeats=False)
        find = partial(self._gather.find, *self._seen(points))
        stages.fork("caustics", "points", find, repeats=kind.captured, apart=True)

    def fill(self, points: ShadingPoints, kind: FrameKind, stages: Stages) -> None:
        """Go on between the `points`, once it is known how bright the picture's indirect light is, if there is any."""
        fill = partial(self._gather.fill, *self._seen(points), self._frame.brightness.value)
        if points.stride > 1:
            stages.fork("caustics", "between", fill, repeats=kind.captured, apart=True)

    def end(self, view: ViewState, kind: FrameKind, stages: Stages) -> None:
        """Have caustics in the picture of a `view`."""
        add = partial(self._gather.add, self._frame.gbuffer, view.radiance)
        stages.run("caustics", add, repeats=kind.captured, waits_for_fork=True)

    def _seen(self, points: ShadingPoints) -> tuple[SceneData, GBuffer, ShadingPoints, CausticLight, SceneFeatures]:
        frame = self._frame
        return frame.scene, frame.gbuffer, points, self._map.light, frame.features

    def _trace(self) -> None:
        frame, casters, table = self._frame, self._casters, self._setup.light_sets.table
        if not casters or table.count == 0:
            self._map.clear()
        else:
            self._map.trace(frame.scene, table, casters, self._seed, frame.features)

    def count(self) -> None:
        """Launch the sum that `counts` reads."""
        self._counter.run([(self._map.count, 0)])

    def counts(self) -> dict[str, int]:
        """How many photons there are, by name, once `count` is ready."""
        return {"caustic_photons": self._counter.totals()[0]}
