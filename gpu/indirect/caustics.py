"""Caustics at the shading points of a picture: the density of caustic photons around each (2009 paper, section 3.1)."""

from functools import cache

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.lights.caustic_map import CausticLight
from gpu.lights.photon_density import NEIGHBOURS, answers, neighbours


@wp.func
def caustic_irradiance(scene: SceneData, lit: CausticLight, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Irradiance of a surface point by caustic photons [W/m²]: those nearest to it, weighed by Epanechnikov's kernel,
    which ends where the farthest is, so that no edge of a disk is seen.
    """
    total = wp.vec3(0.0, 0.0, 0.0)
    found = neighbours(lit.tree, lit.sites.alike, position, normal, lit.reach, -1)
    radius = found.distance[wp.static(NEIGHBOURS - 1)] * lit.share[0]
    for place in range(wp.static(NEIGHBOURS)):
        photon = found.photon[place]
        if photon >= 0 and found.distance[place] < radius:
            away = found.distance[place] / radius
            if answers(scene, lit.tree, lit.sites, photon, position, normal):
                total += lit.tree.photons.flux[photon] * (2.0 - 2.0 * away * away)
    return total / wp.max(PI * radius * radius, 1.0e-20)


@cache
def caustic_kernel(texels: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks."""

    @wp.kernel(module="unique")
    def caustic_kernel(first: int, scene: SceneData, gbuffer: GBuffer, lit: CausticLight,
                       radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
        """One thread a pixel: adds to its `radiance` (pixel,) what its SP reflects of caustics."""
        pixel = first + wp.tid()
        if gbuffer.face[pixel] == NO_HIT:
            return
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        found = caustic_irradiance(scene, lit, gbuffer.position[pixel], gbuffer.geometric_normal[pixel])
        radiance[pixel] += wp.cw_mul(reflectance(gbuffer, pixel), found)

    return caustic_kernel


def add_caustics(scene: SceneData, gbuffer: GBuffer, lit: CausticLight, radiance: wp.array,
                 features: SceneFeatures) -> None:  # fmt: skip
    """Add to `radiance` (pixel,) what the SPs of `gbuffer` reflect of caustics."""
    launch(caustic_kernel(features.texels), len(radiance), [scene, gbuffer, lit, radiance], radiance.device)
