"""About how many rays a frame takes, for those who have to tell beforehand how long it will: no part of any frame."""

from gpu.lights.shadow_map_parameters import SHADOW_MAP_PARAMETERS
from gpu.sample_counts import GLOSSY_BOUNCES, SampleCounts
from gpu.settings import Clustering, Method, RenderSettings

# A pixel's own rays beside those to its lights: the camera's, near field, corrections. Less matters to no estimate.
PIXEL_RAYS = 4
# Of a photon whose irradiance is known: from around it to tell how much of its disk is surface.
SITE_RAYS = 32
# Of a light path of caustics: to its emitter and to where it ends, most often through two faces of glass.
CAUSTIC_RAYS = 4
# Of a path's vertex: to the next one, and to a light.
VERTEX_RAYS = 2


def frame_rays(settings: RenderSettings, counts: SampleCounts, pixels: int) -> float:
    """How many rays a frame of so many pixels traces at most, roughly.

    With a wanted time or error the counts of clusters change from frame to frame, and `counts` may be any.
    """
    own = pixels * (PIXEL_RAYS + counts.samples) + counts.caustic_photons * (CAUSTIC_RAYS + SITE_RAYS)
    lights = counts.vpls * VERTEX_RAYS
    if settings.method is Method.PATH:
        return float(pixels * counts.samples * VERTEX_RAYS * (1 + (settings.bounces or GLOSSY_BOUNCES)))
    if settings.method is Method.PHOTON_GATHER:
        gathered = min(counts.sp_clusters, pixels) * counts.gather_rays
        sites = settings.cut_nodes or counts.photons
        return float(own + counts.photons + sites * SITE_RAYS + gathered)
    if settings.method is Method.EXACT_VPL:
        return float(own + lights + pixels * counts.vpls)
    if settings.method is Method.RSM_DISKS:
        maps = SHADOW_MAP_PARAMETERS.most_maps * counts.shadow_map**2
        return float(own + maps + min(counts.sp_clusters, pixels) * counts.vpl_clusters)
    if settings.clustering is Clustering.VPLS:
        return float(own + lights + pixels * counts.vpl_clusters)
    clusters = min(counts.sp_clusters, pixels)
    pairs = clusters * (counts.vpls if settings.clustering is Clustering.SPS else counts.vpl_clusters)
    return float(own + lights + pairs)
