"""What glass and veils show besides the branch that the G-buffer follows: both are seen at the first of a pixel's way
(the 2009 paper, section 3.1). The other one, mostly what glass reflects, ends in the light that VPLs or photons know.
"""

from typing import Any

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.specular_chain import ChainSamples, seen_end
from gpu.indirect.illumination import Illumination
from gpu.indirect.lobe_light import KnownLight, irradiance_by_vpls
from gpu.vpl.radiosity_cache import RadiosityCache


@made_for(*LOOK, "one_sided", "blend", "sheer", "glass", "panes", "backdrop", "environment", "dispersion")
def other_branch_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features`; lookup, data: as of gpu.indirect.illumination.Illumination."""
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
        lit: data,
        found: wp.array[wp.vec3],
    ) -> None:
        """One thread a pixel: what the other branch shows, `found` (pixel,). cameras: one element."""
        pixel = first + wp.tid()
        found[pixel] = wp.vec3(0.0, 0.0, 0.0)
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
            arriving = lookup(lit, surface.position, surface.geometric_normal).irradiance
            reflected = wp.cw_mul(even_reflectance(surface, end.to_viewer), arriving) / PI
            light += wp.cw_mul(end.throughput, reflected)
        found[pixel] = light

    return other_branch_kernel


@wp.kernel
def add_light_kernel(first: int, light: wp.array[wp.vec3], radiance: wp.array[wp.vec3]) -> None:
    """One thread a pixel: adds `light` (pixel,) to its `radiance` (pixel,)."""
    pixel = first + wp.tid()
    radiance[pixel] += light[pixel]


class OtherBranch:
    """The light [W/m²/sr] that other branches show in an image of `size` (width, height): `find`, then `add`.

    Chains of few pixels are long, so most of a GPU waits for these: other stages may run beside.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self._size = size
        self._light = wp.zeros(size[0] * size[1], dtype=wp.vec3, device=device)

    def find(
        self,
        scene: SceneData,
        camera: wp.array,
        samples: ChainSamples,
        gbuffer: GBuffer,
        known: KnownLight,
        features: SceneFeatures,
        photons: Illumination | None = None,
    ) -> None:
        """Find what pixels of a `gbuffer` that is filled by `samples`, which split, do not show.

        camera: (1,) CameraData; photons: which tell of indirect light in place of the VPLs that `known` has.
        """
        lit = photons.lit if photons else known.lit
        which = (photons.lookup, photons.data) if photons else (irradiance_by_vpls, RadiosityCache)
        inputs = [scene, camera, image_size(self._size), samples, gbuffer, known, lit, self._light]
        launch(other_branch_kernel(features, *which), len(self._light), inputs, self._light.device)

    def add(self, radiance: wp.array) -> None:
        """Add it to `radiance` (pixel,)."""
        launch(add_light_kernel, len(self._light), [self._light, radiance], self._light.device)
