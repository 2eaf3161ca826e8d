"""What a frame of `fuzzy-vpl` is made of, and what it did not have to do, as counts by name."""

from dataclasses import dataclass

import warp as wp

from gpu.core.reduce import Counter
from gpu.device_scene.data import NO_HIT
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_correction import FuzzyCorrection
from gpu.methods.fuzzy_view import FuzzyView, KeptLight
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT

MORE_RAYS = ("suspected", "refined", "bright")


class FuzzyCounter:
    """Counts what stages left on the device; its arrays are allocated once."""

    def __init__(self, device: wp.Device) -> None:
        self._counter = Counter(13, device)

    def run(self, frame: FrameArrays, view: FuzzyView, kept: KeptLight, correction: FuzzyCorrection,
            near: wp.array) -> None:  # fmt: skip
        """Sum up what a frame with indirect light left, and count the pixels that see nothing.

        near (sp,): 1 where a ray found near-field light.
        """
        arrays = [
            (view.points.count, 0),
            (correction.suspected.count, 0),
            (correction.refined.count, 0),
            (correction.bright.count, 0),
            (kept.visibility.rays, 0),
            (kept.visibility.shared, 0),
            (view.clustering.clusters.used, 0),
            (view.clustering.clusters.fresh, 0),
            (frame.indirect.pairs, 0),
            (view.histories.indirect.known, 0),
            (near, 0),
            (view.clustering.deficit, int(UNASSIGNED_DEFICIT)),
        ]
        self._counter.run(arrays, [(frame.gbuffer.face, int(NO_HIT))])

    def run_direct(self, frame: FrameArrays) -> None:
        """Count the pixels of a frame without indirect light that see nothing."""
        self._counter.run([], [(frame.gbuffer.face, int(NO_HIT))])

    def empty(self) -> int:
        """Pixels that see nothing, once `run_direct` is ready."""
        return self._counter.totals()[0]

    def totals(self) -> "FuzzyTotals":
        """What `run` counted, once that is ready."""
        return FuzzyTotals(*self._counter.totals())


@dataclass(frozen=True)
class FuzzyTotals:
    """Sums over a frame: points shaded and with more rays, rays and pairs of clusters, clusters in use and new, …"""

    shaded: int
    suspected: int
    refined: int
    bright: int
    rays: int
    shared: int
    used: int
    fresh: int
    close: int
    known: int
    near: int
    unassigned_deficit: int
    empty: int

    def counts(self, *, corrected: bool) -> dict[str, int]:
        """Points and rays by name; corrected: whether any had more rays."""
        more = {name: getattr(self, name) if corrected else 0 for name in MORE_RAYS}
        unassigned = self.unassigned_deficit // int(UNASSIGNED_DEFICIT)
        rays = {"rays": self.rays, "near": self.near}
        return {"shaded": self.shaded, **more, **rays, "unassigned": unassigned, "empty": self.empty}

    def skips(self, pixels: int, vpl_clusters: int, *, reads_history: bool) -> dict[str, int]:
        """What was left out, by the names of gpu.settings.Skips."""
        return {
            "interpolated": pixels - self.shaded - self.empty,
            "kept_clusters": vpl_clusters * (self.used - self.fresh),
            "temporal_reuse": self.known if reads_history else 0,
            "facing_away": vpl_clusters * self.fresh - self.rays - self.shared,
            "shared_weak_rays": self.shared,
            "far_field_sums": self.shaded * vpl_clusters - self.close,
        }


NOTHING = dict.fromkeys(("shaded", *MORE_RAYS, "rays", "near", "unassigned"), 0)
