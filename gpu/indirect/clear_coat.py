"""What clear coats reflect (KHR_materials_clearcoat), over what is below them.

A coat is a dielectric's specular lobe: direct light is found as any surface's is, indirect light by a ray of the lobe,
mostly a sharp one, which ends in the light that VPLs or photons know. The G-buffer's throughput leaves a place for it.
Where chains are drawn, those that go on from the coat find its indirect light, those that end below its direct light.
"""

from typing import Any

import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import sample_lobe
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.scattering import PartChoice, coat_share, part_of
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import hit_at, surface_at
from gpu.direct.direct_light import DirectSamples, area_light, delta_light, samples_by_power
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.specular_chain import has_coat_apart
from gpu.indirect.illumination import Illumination
from gpu.indirect.lobe_light import LOBE_PAIR, NO_EMISSION, KnownLight, irradiance_by_vpls, light_seen, lobe_ray
from gpu.sampling.sobol import sobol_pair_at
from gpu.vpl.radiosity_cache import RadiosityCache

# What is below a coat at grazing incidence, where there is nothing left for it.
LEAST_BELOW = wp.constant(1.0e-3)


@made_for(*LOOK, "panes", "glass", "backdrop", "environment")
def clear_coat_kernel(features: SceneFeatures, lookup: wp.Function, data: Any) -> wp.Kernel:
    """The kernel for scenes of these `features`; lookup, data: as of gpu.indirect.illumination.Illumination."""
    specialise, seen = specialisation(features), light_seen(lookup, data)

    @wp.kernel(module="unique", module_options={"max_unroll": 1})
    def clear_coat_kernel(
        first: int,
        scene: SceneData,
        image: ImageSize,
        gbuffer: GBuffer,
        known: KnownLight,
        lit: data,
        samples: DirectSamples,
        radiance: wp.array[wp.vec3],
    ) -> None:
        """One thread a pixel: adds to `radiance` (pixel,) what the coat of its SP shows, if there is one [W/m²/sr]."""
        pixel = first + wp.tid()
        face = gbuffer.face[pixel]
        if face == NO_HIT:
            return
        if scene.materials[scene.triangle_material[face]].coat == 0.0:
            return
        scene = specialise(scene)
        view = gbuffer.to_camera[pixel]
        surface = surface_at(scene, hit_at(scene, face, gbuffer.position[pixel]), -view)
        share = coat_share(surface, view)
        if share == 0.0 or (known.followed and not has_coat_apart(surface)):
            return
        choice = PartChoice()
        choice.coat = True
        coat = part_of(surface, choice)
        place = morton_2d(pixel % image.width, pixel // image.width)
        frame_index = samples.frame_index[0]
        light = wp.vec3(0.0, 0.0, 0.0)
        if known.direct:
            light = delta_light(scene, known.table, coat, view)
            own = samples_by_power(place, frame_index * samples.count, samples.count, samples.seed)
            light += area_light(scene, known.table, coat, view, own)
        point = sobol_pair_at(place, frame_index, LOBE_PAIR, samples.seed)
        lobe = sample_lobe(coat, view, point.x, point.y)
        if known.indirect and lobe.density > 0.0:
            ray = lobe_ray(coat, lobe.direction, NO_EMISSION, place, frame_index, samples.seed)
            light += wp.cw_mul(lobe.weight, seen(scene, known, lit, ray).light)
        above = gbuffer.throughput[pixel] * (share / wp.max(1.0 - share, LEAST_BELOW))
        radiance[pixel] += wp.cw_mul(above, light)

    return clear_coat_kernel


def add_clear_coat(
    scene: SceneData,
    size: tuple[int, int],
    gbuffer: GBuffer,
    known: KnownLight,
    samples: DirectSamples,
    radiance: wp.array,
    features: SceneFeatures,
    photons: Illumination | None = None,
) -> None:
    """Add to `radiance` (pixel,) what coats of the SPs in `gbuffer` show of what is `known` [W/m²/sr].

    samples: of direct light, and which of the lobes' these are; size: (width, height); photons: which tell of indirect
    light in place of the VPLs that `known` has.
    """
    image, lit = image_size(size), photons.lit if photons else known.lit
    which = (photons.lookup, photons.data) if photons else (irradiance_by_vpls, RadiosityCache)
    inputs = [scene, image, gbuffer, known, lit, samples, radiance]
    launch(clear_coat_kernel(features, *which), size[0] * size[1], inputs, radiance.device, weight=samples.count)
