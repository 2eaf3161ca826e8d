"""Centres of shading clusters, where incident light is sampled, and what a walk keeps of them for its next frame."""

import warp as wp


@wp.struct
class ShadingClusters:
    """The clusters' centres, which are SPs: position, normal, geometric_normal (cluster,); apparent (cluster,): where
    they seem to be (gpu.gbuffer.gbuffer); spacing (cluster,): the distance to neighbours, 0 for a cluster that is not
    in use.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    apparent: wp.array[wp.vec3]
    spacing: wp.array[float]


@wp.struct
class KeptCentres:
    """What a frame of a walk leaves to the next: position, normal, geometric_normal, apparent (cluster,), as in
    ShadingClusters; used (cluster,): 1 where there is one; accepted (1,): as in KeepingParameters; frames (1,): how
    many have gone on with it.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    apparent: wp.array[wp.vec3]
    used: wp.array[int]
    accepted: wp.array[float]
    frames: wp.array[int]
