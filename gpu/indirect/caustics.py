"""Caustics at the shading points of a picture: the density of caustic photons around each (2009 paper, section 3.1).

Disks are of the photons, not of the points: light then does not spread over what is dark beside a caustic, and a point
reads little more than the photons that light it.
"""

import warp as wp

from gpu.clustering.grid import separation
from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.lights.caustic_map import CausticLight
from gpu.lights.disk_grid import CORNERS, LEVELS, bucket_at, disk_level, reaches
from gpu.lights.photon_density import answers


@wp.func
def caustic_irradiance(scene: SceneData, lit: CausticLight, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Irradiance of a surface point by caustic photons [W/m²]: of those in whose disks it lies, each of which spreads
    its flux over its own by Epanechnikov's kernel, so that no edge of a disk is seen.
    """
    total = wp.vec3(0.0, 0.0, 0.0)
    share = lit.share[0]
    for level in range(LEVELS):
        bucket = bucket_at(lit.grid, position, level, share)
        for place in range(lit.grid.starts[bucket], lit.grid.starts[bucket + 1]):
            if reaches(lit.grid, place, position):
                photon = lit.grid.entries[place] // CORNERS
                radius = lit.sites.radius[photon] * share
                photon_normal = lit.tree.photons.normal[photon]
                away = separation(lit.sites.alike, position, normal, lit.tree.photons.position[photon], photon_normal)
                lights = wp.dot(photon_normal, normal) > lit.sites.alike.normal_threshold and away < radius
                if lights and disk_level(lit.grid, radius, share) == level:
                    open_way = answers(scene, lit.tree, lit.sites, photon, position, normal)
                    if open_way:
                        weight = 2.0 - 2.0 * (away * away) / (radius * radius)
                        total += lit.tree.photons.flux[photon] * (weight / (PI * radius * radius))
    return total


@made_for(*LOOK)
def caustic_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def caustic_kernel(first: int, scene: SceneData, gbuffer: GBuffer, lit: CausticLight,
                       radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
        """One thread a pixel: adds to its `radiance` (pixel,) what its SP reflects of caustics."""
        pixel = first + wp.tid()
        if gbuffer.face[pixel] == NO_HIT:
            return
        scene = specialise(scene)
        reflected = reflectance(gbuffer, pixel)
        if brightness(reflected) > 0.0:
            found = caustic_irradiance(scene, lit, gbuffer.position[pixel], gbuffer.geometric_normal[pixel])
            radiance[pixel] += wp.cw_mul(reflected, found)

    return caustic_kernel


def add_caustics(scene: SceneData, gbuffer: GBuffer, lit: CausticLight, radiance: wp.array,
                 features: SceneFeatures) -> None:  # fmt: skip
    """Add to `radiance` (pixel,) what the SPs of `gbuffer` reflect of caustics."""
    launch(caustic_kernel(features), len(radiance), [scene, gbuffer, lit, radiance], radiance.device)
