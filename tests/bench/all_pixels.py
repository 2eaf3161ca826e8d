"""Every pixel of the reflective shadow maps as a VPL: what clusters of `rsm-disks` stand for (its paper's Fig. 1)."""

from functools import partial

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.core.stages import Stages
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import connection
from gpu.device_scene.specialisation import part_glass_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.exact_gather import exact_gather_kernel
from gpu.indirect.irradiance import allocate_indirect
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.method import RenderSetup
from gpu.methods.rsm_disks import RsmDisks
from gpu.sample_counts import sample_counts_of
from gpu.scene.types import Camera, Floats
from gpu.settings import RenderSettings
from gpu.vpl.build import unclustered
from gpu.vpl.light_sets import LightSets
from tests.bench.subjects import Subject

PAIRS_A_LAUNCH = 1 << 28


@wp.func
def nothing_between(scene: SceneData, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> bool:
    """As gpu.device_scene.rays.connected where nothing hides anything."""
    return True


class AllPixels:
    """Pictures of a subject by all pixels of the maps that `settings` ask for; light_sets: the subject's.

    Its indirect light alone, of Lambertian surfaces: each pixel has its share of its cluster's disk.
    """

    def __init__(self, subject: Subject, settings: RenderSettings, light_sets: LightSets) -> None:
        counts = sample_counts_of(settings, subject.device_scene.device)
        setup = RenderSetup(subject.device_scene, light_sets, subject.size, settings, counts, lambda what, share: None)
        self._method, self._setup = RsmDisks(setup), setup
        self._frame = FrameArrays(subject.device_scene, subject.size, lambertian=True)
        self._out = allocate_indirect(setup.pixels, setup.device)

    def render(self, camera: Camera) -> Floats:
        """The picture from `camera`, (height, width, 3), with a shadow ray a pair if `settings` have shadows."""
        frame, setup = self._frame, self._setup
        view = self._method.new_view()
        view.set_camera(camera)
        stages = Stages(setup.device)
        stages.stepwise = True
        stages.start_frame()
        self._method.render(view, stages, 0)
        vpls = unclustered(setup.device_scene, self._method.lights.vpls)
        frame.trace_primary_rays(view.camera)
        frame.shading_points.find(frame.gbuffer)
        connect = connection(frame.scene) if setup.settings.indirect_shadows else nothing_between
        kernel, step = exact_gather_kernel(part_glass_of(frame.scene), connect), max(1, PAIRS_A_LAUNCH // setup.pixels)
        gather = partial(launch, kernel, setup.pixels)
        for begin in range(0, vpls.count, step):
            run = begin, min(begin + step, vpls.count)
            gather([frame.scene, frame.gbuffer, frame.shading_points.points, vpls, *run, self._out], setup.device)
        return reflected(frame.gbuffer, self._out.irradiance, setup.size)


def reflected(gbuffer: GBuffer, irradiance: wp.array, size: tuple[int, int]) -> Floats:
    """The radiance that Lambertian surfaces send of it."""
    seen = (gbuffer.face.numpy() != int(NO_HIT))[:, None]
    radiance = irradiance.numpy() * gbuffer.albedo.numpy() * gbuffer.throughput.numpy() / np.pi
    return np.asarray(np.where(seen, radiance, 0.0).reshape(size[1], size[0], 3), np.float32)
