"""What is known of indirect light by clusters of shading points, and which of them know an SP's light well."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from gpu.core.parameters import parameters
from gpu.indirect.far_field import FarLight
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.vpl_clusters import VplClusters


@wp.struct
@dataclass
class GuideParameters:
    """Which representatives know an SP's light well.

    farthest: away they are at most, in their spacings; least_cosine: between their normals and the SP's, at least.
    """

    farthest: float = 3.0
    least_cosine: float = 0.8


GUIDE_PARAMETERS = parameters(GuideParameters)


@wp.struct
class ClusteredLight:
    """SP clusters and VPL clusters, visibility between them, and what SP clusters know of far light.

    visibility (SP cluster, word): bit b of word w is 1 where the representative sees VPL cluster 32·w + b.
    """

    clusters: SpClusters
    visibility: wp.array2d[wp.uint32]
    vpls: VplClusters
    far: FarLight
    guide: GuideParameters


def clustered_light(clusters: SpClusters, visibility: wp.array, vpls: VplClusters, far: FarLight) -> ClusteredLight:
    """These as kernels take them."""
    light = ClusteredLight()
    light.clusters, light.visibility, light.vpls, light.far = clusters, visibility, vpls, far
    light.guide = GUIDE_PARAMETERS
    return light


@cache
def guides_of(fuzziness: int) -> wp.Function:
    """The function that tells which of an SP's F = `fuzziness` clusters know of its light.

    guides(known, sp, position, normal) has `cluster`, all of them, and `weight`, their shares, which go to those
    that know it well, if any does.
    """
    ints: Any = wp.types.vector(length=fuzziness, dtype=int)
    floats: Any = wp.types.vector(length=fuzziness, dtype=float)

    @wp.struct
    class Guides:
        cluster: ints
        weight: floats

    @wp.func
    def guides(known: ClusteredLight, sp: int, position: wp.vec3, normal: wp.vec3) -> Guides:
        found = Guides()
        clusters = known.clusters
        total = float(0.0)
        for f in range(wp.static(fuzziness)):
            cluster = clusters.cluster[f, sp]
            weight = clusters.weight[f, sp]
            off = wp.length(clusters.position[cluster] - position)
            alike = wp.dot(clusters.normal[cluster], normal)
            if off > known.guide.farthest * clusters.spacing[cluster] or alike < known.guide.least_cosine:
                weight = 0.0
            found.cluster[f] = cluster
            found.weight[f] = weight
            total += weight
        for f in range(wp.static(fuzziness)):
            if total > 0.0:
                found.weight[f] = found.weight[f] / total
            else:
                found.weight[f] = clusters.weight[f, sp]
        return found

    return guides


@wp.func
def cluster_visibility_of(guided: Any, visibility: wp.array2d[wp.uint32], cluster: int, fuzziness: int) -> float:
    """The share of an SP's clusters that see a VPL cluster; visibility: as of ClusteredLight."""
    share = float(0.0)
    for f in range(fuzziness):
        bits = visibility[guided.cluster[f], cluster // 32] >> wp.uint32(cluster % 32)
        share += guided.weight[f] * float(bits & wp.uint32(1))
    return share
