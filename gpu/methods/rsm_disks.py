"""`rsm-disks`: clusters of reflective shadow maps as disk lights, the 2012 paper's method, for lights that move.

One bounce, of lights as they are in the frame. Its future work is here: visibility, by clusters of SPs as in
`fuzzy-vpl`, whose stages it shares, and receivers that are not diffuse, by the BSDF that all methods share.
"""

from gpu.core.reduce import Counter
from gpu.lights.shadow_map_parameters import SHADOW_MAP_PARAMETERS
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.fuzzy_view_state import FuzzyViewState
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.method import FrameStatistics, RenderSetup
from gpu.methods.rsm_lights import RsmLights, by_rays
from gpu.sample_counts import SampleCounts
from gpu.settings import RenderSettings

# Device memory that a pixel of a map takes with its part of radiosity, and a seed that a viewer's walk keeps.
MAP_PIXEL_BYTES, SEED_BYTES = 460, 8


class RsmDisks(FuzzyVpl):
    """Steps 3 to 6 of `fuzzy-vpl` with lights of reflective shadow maps."""

    stage_names = ("gbuffer", "caustic-photons", "history", "shadow-maps", "map-clusters", "disks", "cluster",
                   "visibility", "shade", "correct", "refine", "bright", "direct", "caustics", "near", "interpolate",
                   "gloss", "branches", "antialias", "keep")  # fmt: skip
    lights: RsmLights

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """As `fuzzy-vpl`, and as many maps as a scene may have."""
        shared, view = FuzzyVpl.cluster_bytes(sample_counts)
        maps = SHADOW_MAP_PARAMETERS.most_maps * sample_counts.shadow_map**2
        return shared + MAP_PIXEL_BYTES * maps, view + SEED_BYTES * sample_counts.vpl_clusters

    @staticmethod
    def traces_lobes(settings: RenderSettings) -> bool:
        """As `fuzzy-vpl`, with lights that are looked at by rays."""
        return FuzzyVpl.traces_lobes(settings) and by_rays(settings)

    def __init__(self, setup: RenderSetup) -> None:
        super().__init__(setup)
        self._map_counter = Counter(2, setup.device)

    def _first_lights(self) -> ClusteredLights:
        return RsmLights(self._setup, self._frame, self._most)

    def count(self, view: FuzzyViewState) -> None:
        """As `fuzzy-vpl`, and the maps' pixels with light, and clusters without members."""
        super().count(view)
        if self.lights.has_indirect:
            self._map_counter.run([(self.lights.lit(), 0)], [(self.lights.clustering.clusters.members, 0)])

    def statistics(self, view: FuzzyViewState) -> FrameStatistics:
        """Those of `fuzzy-vpl`; vpls: pixels with light; vpl_clusters: those with members."""
        counts, skips = super().statistics(view)
        if self.lights.has_indirect:
            lit, empty = self._map_counter.totals()
            counts |= {"vpls": lit, "vpl_clusters": self.lights.vpls.count - empty}
        return counts, skips | {"unchanged_lights": 0}
