"""The side of a translucent surface on which a pixel has its shading point in frames that are averaged: it is drawn.

So all that looks for the light of a shading point has to know of one side only, and their mean shows both.
"""

import warp as wp

from gpu.core.image_size import ImageSize
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import is_fibrous, is_translucent, largest
from gpu.device_scene.data import NO_HIT
from gpu.device_scene.even_light import SIDE_PAIR, even_reflectance, even_through, left_by_fibres, turned
from gpu.gbuffer.specular_chain import ChainEnd, ChainSamples
from gpu.sampling.sobol import sobol_pair_at

# A side that scatters little may be lit by much more: it is drawn as often as this at least, but for what rounding has.
LEAST_OFTEN = wp.constant(0.3)
LEAST_SCATTERED = wp.constant(1.0e-4)


@wp.func
def drawn_side(end: ChainEnd, samples: ChainSamples, pixel: int, image: ImageSize) -> ChainEnd:
    """What a pixel's chain ends at, on one side of it. The less often a side is drawn, the more of its light counts."""
    surface = end.surface
    # What glass shows besides is seen from one side alone.
    mixed = surface.glass > 0.0 and not samples.lobes
    if end.face == NO_HIT or mixed or not is_translucent(surface):
        return end
    through = largest(even_through(surface, end.to_viewer))
    front = largest(even_reflectance(surface, end.to_viewer) - even_through(surface, end.to_viewer))
    share = float(1.0)
    if front > LEAST_SCATTERED:
        share = wp.clamp(through / (through + front), LEAST_OFTEN, 1.0 - LEAST_OFTEN)
    place = morton_2d(pixel % image.width, pixel // image.width)
    if sobol_pair_at(place, samples.frame_index[0], SIDE_PAIR, samples.seed).x < share:
        normal = surface.geometric_normal
        end.surface = turned(surface, end.to_viewer)
        if is_fibrous(surface):
            # What they take depends on where light comes from; they are on the side that is seen.
            end.surface.diffuse = end.surface.diffuse / left_by_fibres(surface, end.to_viewer)
            end.surface.albedo = end.surface.diffuse
            end.surface.sheen = surface.sheen
            end.surface.sheen_roughness = -surface.sheen_roughness
        end.to_viewer = end.to_viewer - normal * (2.0 * wp.dot(normal, end.to_viewer))
        end.throughput = end.throughput / share
    else:
        end.surface.through = wp.vec3(0.0, 0.0, 0.0)
        end.surface.albedo = surface.diffuse
        end.throughput = end.throughput / (1.0 - share)
    return end
