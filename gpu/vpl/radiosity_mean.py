"""The light at any surface point that rays meet, as VPLs around it tell it: what is seen in glossy surfaces.

A mean over several VPLs, each of which knows the radiosity around it (gpu.vpl.radiosity_cache). It is divided by what
surfaces reflect there, and multiplied by what the point itself reflects, so that textures stay sharp.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import separation
from gpu.vpl.radiosity_cache import LEVELS_HELD, RadiosityCache, bucket_around


@dataclass(frozen=True)
class RadiosityMeanParameters:
    """least_reflectance: channels of less than this share of the brightest tell little of the light that they get.
    Compiled in.
    """

    least_reflectance: float = 0.02


RADIOSITY_MEAN_PARAMETERS = RadiosityMeanParameters()


@wp.func
def mean_irradiance(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """The irradiance about a surface point [W/m²]; zero where no VPL tells of it.

    As for `vpl_around`, the smallest cell that knows a VPL tells, but all that are near in it.
    """
    radiosity = wp.vec3(0.0, 0.0, 0.0)
    reflected = wp.vec3(0.0, 0.0, 0.0)
    known = bool(False)
    level = int(lit.lowest[0])
    while not known and level <= lit.highest[0]:
        bucket = bucket_around(lit, position, normal, level)
        begin = lit.starts[bucket]
        end = lit.starts[bucket + 1]
        step = (end - begin + lit.chosen.most_read - 1) // lit.chosen.most_read
        place = begin
        while place < end:
            vpl = lit.entries[place] // LEVELS_HELD
            if wp.dot(lit.normal[vpl], normal) > lit.alike.normal_threshold:
                away = separation(lit.alike, position, normal, lit.position[vpl], lit.normal[vpl]) / lit.radius[vpl]
                if away < lit.chosen.reach:
                    weight = lit.chosen.reach - away
                    radiosity += lit.radiosity[vpl] * weight
                    reflected += lit.reflectance[vpl] * weight
                    known = True
            place += step
        level += 1
    total = wp.max(reflected[0], wp.max(reflected[1], reflected[2]))
    if total <= 0.0:
        return radiosity
    least = wp.vec3(1.0, 1.0, 1.0) * (wp.static(RADIOSITY_MEAN_PARAMETERS.least_reflectance) * total)
    return wp.cw_div(radiosity, wp.max(reflected, least))
