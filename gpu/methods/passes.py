"""The stages that methods with a G-buffer share: its rays, direct light, near-field light, and what is added in the
end.
"""

from dataclasses import dataclass
from functools import partial

import warp as wp

from gpu.core.stages import Stages
from gpu.denoise.antialiasing import PictureHistory
from gpu.denoise.direct_history import DirectHistory
from gpu.denoise.indirect_history import IndirectHistory
from gpu.denoise.reprojection import REPROJECTION_PARAMETERS, PreviousFrame
from gpu.direct.direct_light import add_soft_light, direct_samples, trace_direct_light
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.specular_chain import LIKELIER
from gpu.indirect.clear_coat import add_clear_coat
from gpu.indirect.glossy_reflection import GlossyReflection
from gpu.indirect.illumination import Illumination
from gpu.indirect.light_behind import join_sides, trace_behind
from gpu.indirect.lobe_light import KnownLight, known_light
from gpu.indirect.near_field import NearField
from gpu.indirect.other_branch import OtherBranch
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind, light_samples
from gpu.methods.method import RenderSetup
from gpu.methods.view_state import ViewState
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.vpl_clusters import VplClusters

SETTLED_FRAMES = REPROJECTION_PARAMETERS.settled_frames


def traces_lobes(settings: RenderSettings) -> bool:
    """Whether rays of specular lobes, glass and coats are traced, which end in the light that VPLs know."""
    return settings.near_field


@dataclass(frozen=True)
class Histories:
    """What a walk keeps of its frames: direct and indirect light by surface, pictures, what the last one saw where.

    direct: None where the scene has no soft light; gloss: what rays of specular lobes found, None where there are none;
    pictures: None where edges are left as they are.
    """

    direct: DirectHistory | None
    gloss: DirectHistory | None
    indirect: IndirectHistory
    pictures: PictureHistory | None
    previous: PreviousFrame


class Passes:
    """Runs these stages on the arrays of one size. What is begun goes on beside the stages up to the one that ends
    it.
    """

    def __init__(self, setup: RenderSetup, frame: FrameArrays) -> None:
        self._setup, self._frame = setup, frame
        self._settings = setup.settings
        by_photons = self._settings.method is Method.PHOTON_GATHER
        shows_both = traces_lobes(self._settings) if by_photons else frame.traces_lobes
        splits = shows_both and frame.features.see_through
        self._other_branch = OtherBranch(frame.size, frame.device) if splits else None
        # Lobes that a chain goes on in bring direct light, too.
        whole = self._settings.component is Component.FULL
        self._draws_lobes = whole and (frame.gloss is not None or (by_photons and frame.features.lobes))
        frame.chain_samples.splits, frame.chain_samples.seed = splits, self._settings.seed
        # Shadow maps know light's first bounce alone.
        bounces = 1 if self._settings.method is Method.RSM_DISKS else setup.bounces
        sent = setup.light_sets.table, frame.features, bounces
        self.near_field = NearField(setup.pixels, frame.side_smoothing, setup.device, *sent)

    @property
    def _has_direct(self) -> bool:
        return self._settings.component is not Component.INDIRECT

    def begin(self, view: ViewState, points: ShadingPoints, kind: FrameKind, stages: Stages) -> None:
        """Trace the primary rays, and list the shading `points`."""
        frame = self._frame

        frame.set_numbers(kind.seed, kind.index, kind.index if kind.refines else LIKELIER)
        frame.chain_samples.lobes = draws_lobes = self._draws_lobes and kind.refines

        def gbuffer() -> None:
            frame.numbers.upload()
            frame.trace_primary_rays(view.camera)
            points.find(frame.gbuffer, every=kind.shades_all)

        stages.run("gbuffer", gbuffer, branch=(kind.shades_all, draws_lobes))

    def begin_direct(self, view: ViewState, kind: FrameKind, stages: Stages,
                     histories: Histories | None = None) -> None:  # fmt: skip
        """Begin with direct light, if it is wanted; after `begin`."""
        frame = self._frame
        if not self._has_direct:
            view.radiance.zero_()
            return
        samples = light_samples(self._setup.sample_counts.samples, kind)
        table, area = self._setup.light_sets.table, frame.features.soft

        def rays() -> None:
            seed, probes, seen = self._settings.seed, frame.light_probes, (frame.scene, table, frame.gbuffer)
            if probes:
                probes.run(*seen, seed, frame.features)
            history, known, frames = histories.direct if histories else None, None, frame.nothing
            if history and histories and kind.write_history and kind.read_history and samples > 1:
                known = history.find(frame.gbuffer, histories.previous)
            which = direct_samples(samples, frame.frame_index, seed, probes, known, SETTLED_FRAMES)
            trace_direct_light(*seen, frame.size, which, view.radiance, frame.area_light, frame.features)
            if history and histories and kind.write_history:
                history.take(frame.gbuffer, histories.previous, frame.area_light, read_history=kind.read_history)
                frames = history.frames
            if area and kind.denoise:
                frame.side_smoothing.run(frame.gbuffer, frame.area_light, frames)

        stages.fork("direct", "rays", rays, repeats=kind.captured, branch=kind.read_history)

    def end_direct(self, view: ViewState, kind: FrameKind, stages: Stages) -> None:
        """Have direct light in the picture, if it is wanted."""
        frame = self._frame

        def add() -> None:
            if frame.features.soft:
                add_soft_light(frame.gbuffer, frame.area_light, view.radiance)

        if self._has_direct:
            stages.run("direct", add, repeats=kind.captured, waits_for_fork=True)

    def begin_near(self, points: ShadingPoints, vpls: VplClusters, cache: RadiosityCache, kind: FrameKind,
                   stages: Stages, history: IndirectHistory | None = None) -> None:  # fmt: skip
        """Begin to find by the `cache` what `vpls` lack near field, and light from behind; these rays need no stage but
        the first.

        Where light is shared, what earlier frames of a walk found joins in.
        """
        frame, near = self._frame, self.near_field
        frames = history.frames if history and kind.denoise else self._frame.nothing

        def rays() -> None:
            near.trace(frame.scene, frame.gbuffer, points, vpls, cache, frame.seed, frames)
            if frame.features.translucent:
                known = self._known(cache)
                trace_behind(frame.scene, frame.gbuffer, points, known, frame.seed, near.light, frame.features)
            if history and kind.denoise:
                history.take_near(points, near.light)

        stages.fork("near", "rays", rays, repeats=kind.captured)

    def share_near(self, points: ShadingPoints, guide: wp.array, kind: FrameKind, stages: Stages,
                   history: IndirectHistory | None = None) -> None:  # fmt: skip
        """Begin to smooth what `begin_near` has found; guide (pixel,): irradiance that stays as it is."""
        frames = history.frames if history else self._frame.nothing
        args = self._frame.gbuffer, points, guide, frames
        if kind.denoise:
            stages.fork("near", "sharing", lambda: self.near_field.share(*args), repeats=kind.captured)

    def begin_gloss(self, view: ViewState, cache: "RadiosityCache | None", kind: FrameKind, stages: Stages,
                    histories: Histories | None = None) -> None:  # fmt: skip
        """Begin to find by the `cache`, if there is one, what glossy surfaces and frosted glass show, if there are any
        and no chains go on by way of them, and what glass and veils show besides; after `begin`.
        """
        frame, gloss, other = self._frame, self._frame.gloss, self._other_branch
        if frame.chain_samples.lobes:
            return
        if other and not kind.refines:

            def branches() -> None:
                samples, known = frame.chain_samples, self._known(cache)
                other.find(frame.scene, view.camera, samples, frame.gbuffer, known, frame.features)

            stages.fork("branches", "rays", branches, repeats=kind.captured, apart=True)
        if gloss is None:
            return
        history = histories.gloss if histories else None

        def rays() -> None:
            frames = None
            if history and histories and kind.write_history and kind.read_history:
                frames = history.find(frame.gbuffer, histories.previous)
            which = direct_samples(1, frame.frame_index, self._settings.seed, None, frames, SETTLED_FRAMES)
            gloss.trace(frame.scene, view.camera, frame.gbuffer, self._known(cache), which)
            if history and histories and kind.write_history:
                history.take(frame.gbuffer, histories.previous, gloss.light, read_history=kind.read_history)
            if kind.denoise:
                gloss.share(frame.gbuffer, restores=not kind.read_history)

        stages.fork("gloss", "rays", rays, repeats=kind.captured, branch=kind.read_history)

    def _known(self, cache: "RadiosityCache | None", *, photons: bool = False) -> KnownLight:
        """What rays of lobes end in; photons: whether these tell what the `cache` does elsewhere."""
        return known_light(self._setup.light_sets.table, cache, direct=self._has_direct, photons=photons)

    def end_gloss(self, view: ViewState, cache: "RadiosityCache | None", kind: FrameKind, stages: Stages) -> None:
        """Have in the picture what glossy surfaces reflect, if there are any, by the `cache`, if there is one, what
        clear coats show besides, and what glass and veils do.
        """
        frame, gloss, other = self._frame, self._frame.gloss, self._other_branch
        if frame.chain_samples.lobes:
            if frame.features.coats:
                stages.run("gloss", lambda: self.add_coats(view, kind, cache), repeats=kind.captured)
            return

        def add(gloss: GlossyReflection) -> None:
            gloss.add(frame.gbuffer, view.radiance)
            self.add_coats(view, kind, cache)

        if gloss is not None:
            stages.run("gloss", partial(add, gloss), repeats=kind.captured, waits_for_fork=True)
        if other and not kind.refines:
            stages.run("branches", partial(other.add, view.radiance), repeats=kind.captured, waits_for_fork=True)

    def add_coats(self, view: ViewState, kind: FrameKind, cache: "RadiosityCache | None",
                  photons: Illumination | None = None) -> None:  # fmt: skip
        """Have in the picture what clear coats show, if there are any; of indirect light by `cache` or `photons`, if
        there is either.
        """
        frame = self._frame
        if frame.features.coats and frame.gbuffer.traces_gloss:
            known = self._known(cache, photons=photons is not None)
            known.followed = frame.chain_samples.lobes
            known.indirect = known.indirect and not known.followed
            count = light_samples(self._setup.sample_counts.samples, kind)
            which = direct_samples(count, frame.frame_index, self._settings.seed)
            seen = frame.scene, frame.size, frame.gbuffer
            add_clear_coat(*seen, known, which, view.radiance, frame.features, photons)

    def add_branches(self, view: ViewState, kind: FrameKind, photons: Illumination | None, stages: Stages) -> None:
        """Have in the picture what glass and veils show besides, if there are any, by `photons`, if there are these."""
        frame, other = self._frame, self._other_branch

        def add(other: OtherBranch) -> None:
            seen = frame.scene, view.camera, frame.chain_samples, frame.gbuffer
            other.find(*seen, self._known(None, photons=photons is not None), frame.features, photons)
            other.add(view.radiance)

        if other and not kind.refines:
            stages.run("branches", partial(add, other), repeats=kind.captured)

    def end_indirect(self, view: ViewState, points: ShadingPoints, kind: FrameKind, stages: Stages, *,
                     near: bool) -> None:  # fmt: skip
        """Add the indirect light to the picture; before, near-field light, if `begin_near` was called for it."""
        frame, irradiance = self._frame, self._frame.indirect.irradiance

        def add_near() -> None:
            if frame.features.translucent:
                join_sides(frame.gbuffer, points, self.near_field.light, irradiance)
            else:
                points.add(self.near_field.light, irradiance)

        def reflect() -> None:
            points.reflect(frame.gbuffer, irradiance, frame.brightness.value, view.radiance)

        if near:
            stages.run("near", add_near, repeats=kind.captured, waits_for_fork=True)
        stages.run("interpolate", reflect, repeats=kind.captured)

    def skips(self) -> dict[str, int]:
        """What kernels of primary rays and direct light did not have to know of."""
        features = self._frame.features
        return {
            "absent_alpha": int(not features.alpha),
            "absent_textures": int(not features.textures),
            "absent_gloss": int(self._has_direct and not features.gloss),
        }
