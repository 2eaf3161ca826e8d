"""What shading points show by specular lobes of light that single rays bring, where their albedo takes it as even."""

import warp as wp

from gpu.device_scene.bsdf import is_followed
from gpu.device_scene.even_light import LEAST_REFLECTED, even_reflectance, even_through, over_even
from gpu.gbuffer.gbuffer import GBuffer, surface_of


@wp.func
def received_by_lobe(gbuffer: GBuffer, pixel: int, to_light: wp.vec3) -> wp.vec3:
    """What the SP of a pixel reflects to the camera of light from unit `to_light`, over what its albedo says; 1 where
    frames look along its lobe.
    """
    share = wp.vec3(1.0, 1.0, 1.0)
    if gbuffer.f90[pixel] > 0.0:
        surface = surface_of(gbuffer, pixel)
        if not is_followed(surface):
            view = gbuffer.to_camera[pixel]
            albedo = gbuffer.albedo[pixel]
            if gbuffer.translucent:
                # Of the albedo, light from the viewer's side has this.
                albedo -= even_through(surface, view)
            surface.through = wp.vec3(0.0, 0.0, 0.0)
            even = even_reflectance(surface, view)
            albedo = wp.max(albedo, LEAST_REFLECTED)
            share += wp.cw_div(wp.cw_mul(over_even(surface, view, to_light, even) - share, even), albedo)
    return share
