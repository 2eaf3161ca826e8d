"""Indirect light at every shading point from all polygons, with visibility blended from SP clusters (Eq. 6 and 9 of the
2022 paper, for the lights of Fig. 3 of the 2012 paper).
"""

from functools import cache

import warp as wp

from gpu.core.device import launch
from gpu.core.kahan import Sum, kahan_add
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.clustered_light import ClusteredLight, cluster_visibility_of, guides_of
from gpu.indirect.irradiance import Indirect
from gpu.vpl.polygon_light import Polygons, polygon_irradiance


@cache
def polygon_shading_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that shades SPs of F = `fuzziness` clusters each."""
    guides = guides_of(fuzziness)

    @wp.kernel(module="unique")
    def polygon_shading_kernel(first: int, gbuffer: GBuffer, points: PointList, known: ClusteredLight,
                               polygons: Polygons, out: Indirect) -> None:  # fmt: skip
        """One thread an SP: its light from all polygons, times the share of its SP clusters that see each."""
        sp = first + wp.tid()
        out.pairs[sp] = 0
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(known, sp, position, normal)
        irradiance = Sum()
        for cluster in range(known.vpls.count):
            share = cluster_visibility_of(guided, known.visibility, cluster, wp.static(fuzziness))
            if share > 0.0:
                light = polygon_irradiance(position, normal, polygons, known.vpls, cluster)
                irradiance = kahan_add(irradiance, light * share)
        out.irradiance[pixel] = irradiance.total
        out.pairs[sp] = known.vpls.count

    return polygon_shading_kernel


def shade_by_polygons(fuzziness: int, gbuffer: GBuffer, sps: ShadingPoints, known: ClusteredLight, polygons: Polygons,
                      out: Indirect) -> None:  # fmt: skip
    """Write the indirect light of `sps` from `polygons`, one for each of the VPL clusters `known`, into `out`."""
    inputs = [gbuffer, sps.points, known, polygons, out]
    launch(polygon_shading_kernel(fuzziness), sps.capacity, inputs, sps.device)
