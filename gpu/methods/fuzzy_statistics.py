"""What a frame of `fuzzy-vpl` is made of, and what it did not have to do, as counts by name."""

import warp as wp

from gpu.core.reduce import Counter
from gpu.device_scene.data import NO_HIT
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_view_state import FuzzyViewState
from gpu.methods.method import FrameStatistics
from gpu.methods.passes import Passes
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT

MORE_RAYS = ("suspected", "refined", "bright")
# What is summed up, in this order, before the pixels that see nothing.
SUMMED = ("shaded", *MORE_RAYS, "rays", "shared", "used", "fresh", "close", "known", "near", "deficit")


class FuzzyCounter:
    """Counts what stages left on the device; its arrays are allocated once."""

    def __init__(self, device: wp.Device) -> None:
        self._counter = Counter(len(SUMMED) + 1, device)

    def run(self, frame: FrameArrays, view: FuzzyViewState, lights: ClusteredLights, near: wp.array) -> None:
        """Sum up what a frame left, and count the pixels that see nothing.

        near (sp,): 1 where a ray found near-field light.
        """
        arrays: list[tuple[wp.array, int]] = []
        if lights.has_indirect:
            correction, visibility = lights.correction, lights.known_to(view).visibility
            clusters, looked = view.clustering.clusters, (correction.suspected, correction.refined, correction.bright)
            counts = [view.points.count, *(points.count for points in looked), visibility.rays, visibility.shared]
            marks = [clusters.used, clusters.fresh, frame.indirect.pairs, view.histories.indirect.known, near]
            arrays = [(array, 0) for array in (*counts, *marks)]
            arrays.append((view.clustering.deficit, int(UNASSIGNED_DEFICIT)))
        self._counter.run(arrays, [(frame.gbuffer.face, int(NO_HIT))])

    def statistics(self, view: FuzzyViewState, lights: ClusteredLights, passes: Passes) -> FrameStatistics:
        """Counts and skips (gpu.settings.Skips) by name, of the view's last frame, once that is ready."""
        vpls, clusters = lights.vpls.members.count if lights.vpls.count else 0, lights.vpls.count
        counts = {"vpls": vpls, "vpl_clusters": clusters, "sp_clusters": view.clustering.count}
        if not lights.has_indirect:
            nothing = dict.fromkeys(("shaded", *MORE_RAYS, "rays", "near", "unassigned"), 0)
            return counts | nothing | {"empty": self._counter.totals()[0]}, passes.skips()
        *sums, empty = self._counter.totals()
        of, kept = dict(zip(SUMMED, sums, strict=True)), lights.known_to(view)
        counts |= {name: of[name] for name in ("shaded", "rays")} | {"near": of["near"] if kept.near else 0}
        counts |= {name: of[name] if kept.corrected else 0 for name in MORE_RAYS}
        counts |= {"unassigned": of["deficit"] // int(UNASSIGNED_DEFICIT), "empty": empty}
        skips = {
            **passes.skips(),
            "interpolated": view.pixels - of["shaded"] - empty,
            "unchanged_lights": vpls if lights.are_kept else 0,
            "kept_clusters": clusters * (of["used"] - of["fresh"]),
            "temporal_reuse": of["known"] if kept.reads_history else 0,
            "facing_away": clusters * of["fresh"] - of["rays"] - of["shared"],
            "shared_weak_rays": of["shared"],
            "far_field_sums": of["shaded"] * clusters - of["close"],
        }
        return counts, skips
