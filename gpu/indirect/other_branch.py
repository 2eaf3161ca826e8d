"""What glass and veils show besides the branch that the G-buffer follows: both are seen at the first of a pixel's way
(the 2009 paper, section 3.1). The other one, mostly what glass reflects, ends in the light that VPLs know.
"""

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.bsdf import even_reflectance
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.specular_chain import ChainSamples, seen_end
from gpu.indirect.lobe_light import KnownLight
from gpu.vpl.radiosity_mean import mean_irradiance


@made_for(*LOOK, "one_sided", "blend", "glass", "panes", "backdrop", "environment")
def other_branch_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def other_branch_kernel(
        first: int,
        scene: SceneData,
        cameras: wp.array[CameraData],
        image: ImageSize,
        samples: ChainSamples,
        gbuffer: GBuffer,
        known: KnownLight,
        radiance: wp.array[wp.vec3],
    ) -> None:
        """One thread a pixel: adds to `radiance` (pixel,) what the other branch shows. cameras: one element."""
        pixel = first + wp.tid()
        # Glass takes something of the light, if only what it reflects, and so do veils.
        if gbuffer.throughput[pixel] == wp.vec3(1.0, 1.0, 1.0):
            return
        scene = specialise(scene)
        if not (scene.specular or scene.blended):  # a coat takes something, too
            return
        end = seen_end(scene, pixel_ray(cameras[0], pixel, image), pixel, image, samples, True)
        light = wp.vec3(0.0, 0.0, 0.0)
        if known.direct:
            light = end.emitted
        if end.face != NO_HIT and known.indirect:
            surface = end.surface
            arriving = mean_irradiance(known.lit, surface.position, surface.geometric_normal)
            reflected = wp.cw_mul(even_reflectance(surface, end.to_viewer), arriving) / PI
            light += wp.cw_mul(end.throughput, reflected)
        radiance[pixel] += light

    return other_branch_kernel


def add_other_branch(scene: SceneData, camera: wp.array, size: tuple[int, int], samples: ChainSamples,
                     gbuffer: GBuffer, known: KnownLight, radiance: wp.array, features: SceneFeatures
                     ) -> None:  # fmt: skip
    """Add to `radiance` (pixel,) what pixels of a `gbuffer` that is filled by `samples`, which split, do not show.

    camera: (1,) CameraData; size: (width, height).
    """
    inputs = [scene, camera, image_size(size), samples, gbuffer, known, radiance]
    kernel = other_branch_kernel(features)
    launch(kernel, size[0] * size[1], inputs, radiance.device)
