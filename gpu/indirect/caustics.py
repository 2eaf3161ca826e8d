"""Caustics at the shading points of a picture: the density of caustic photons around each (2009 paper, section 3.1).

Disks are of the photons, not of the points: light then does not spread over what is dark beside a caustic, and a point
reads little more than the photons that light it.
"""

import warp as wp

from gpu.clustering.grid import separation
from gpu.core.constants import PI
from gpu.core.device import launch, launch_together
from gpu.core.image_size import ImageSize
from gpu.core.intrinsics import lanes_of, vector_sum
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.gbuffer.gbuffer import GBuffer, behind_share, reflectance
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import SparseShadingParameters, interpolated_irradiance, is_edge_between
from gpu.lights.caustic_map import CausticLight
from gpu.lights.disk_grid import CORNERS, LEVELS, bucket_at, disk_level, reaches
from gpu.lights.photon_density import answers


@wp.func
def caustic_irradiance(scene: SceneData, lit: CausticLight, position: wp.vec3, normal: wp.vec3, lane: int,
                       lanes: int) -> wp.vec3:  # fmt: skip
    """Irradiance of a surface point by caustic photons [W/m²]: of those in whose disks it lies, each of which spreads
    its flux over its own by Epanechnikov's kernel, so that no edge of a disk is seen.

    Each of the `lanes` (gpu.core.intrinsics) of a point looks at disks of its own: in a room of shining chairs a point
    has 7 rays to photons in the mean, but one in a hundred has 48.
    """
    total = wp.vec3(0.0, 0.0, 0.0)
    share = lit.share[0]
    for level in range(LEVELS):
        bucket = bucket_at(lit.grid, position, level, share)
        for place in range(lit.grid.starts[bucket] + lane, lit.grid.starts[bucket + 1], lanes):
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
    return vector_sum(total, lanes)


@made_for(*LOOK)
def caustic_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, translucent = specialisation(features), features.translucent

    @wp.kernel(module="unique")
    def caustic_kernel(first: int, scene: SceneData, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int],
                       lit: CausticLight, lanes: int, found: wp.array[wp.vec3]) -> None:  # fmt: skip
        """`lanes` threads a listed pixel: its irradiance by caustics [W/m²] into found (pixel,), of both sides
        as far as it reflects that of either by its albedo.

        pixels (place,): those that are listed, of which count (1,) says how many there are.
        """
        index = first + wp.tid()
        place = index // lanes
        lane = index % lanes
        if place >= count[0]:
            return
        pixel = pixels[place]
        position, normal = gbuffer.position[pixel], gbuffer.geometric_normal[pixel]
        scene = specialise(scene)
        light = caustic_irradiance(scene, lit, position, normal, lane, lanes)
        if wp.static(translucent):
            behind = behind_share(gbuffer, pixel)
            if largest(behind) > 0.0:
                other = caustic_irradiance(scene, lit, position, -normal, lane, lanes)
                light += wp.cw_mul(behind, other - light)
        if lane == 0:
            found[pixel] = light

    return caustic_kernel


@wp.kernel
def interpolate_caustics_kernel(first: int, gbuffer: GBuffer, image: ImageSize, sparse: SparseShadingParameters,
                                listed: wp.array[int], mean: wp.array[float], found: wp.array[wp.vec3],
                                edges: wp.array[int], count: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel without an SP: interpolates what anchors `found` (pixel,), and lists it at edges of that.

    listed (pixel,): 1 for pixels with SPs; mean (1,): brightness of the picture; edges (place,), count (1,): the list.
    """
    pixel = first + wp.tid()
    if gbuffer.face[pixel] == NO_HIT or listed[pixel] == 1:
        return
    around = interpolated_irradiance(gbuffer, pixel, image, sparse, found)
    found[pixel] = around.light
    if is_edge_between(around, reflectance(gbuffer, pixel), mean[0], sparse):
        edges[wp.atomic_add(count, 0, 1)] = pixel


@wp.kernel
def reflect_caustics_kernel(first: int, gbuffer: GBuffer, found: wp.array[wp.vec3],
                            radiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: adds to its `radiance` (pixel,) what it reflects of what was `found` (pixel,)."""
    pixel = first + wp.tid()
    if gbuffer.face[pixel] != NO_HIT:
        radiance[pixel] += wp.cw_mul(reflectance(gbuffer, pixel), found[pixel])


class CausticGather:
    """Gathers caustics at the SPs of a picture of so many `pixels`, and wherever their edges lie between these: by
    `find`, then `fill`, then `add`.
    """

    def __init__(self, pixels: int, device: wp.Device) -> None:
        self._found = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self._edges = wp.zeros(pixels, dtype=int, device=device)
        self._count = wp.zeros(1, dtype=int, device=device)

    def find(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, lit: CausticLight,
             features: SceneFeatures) -> None:  # fmt: skip
        """Gather at the SPs."""
        self._gather(scene, gbuffer, (sps.pixels, sps.count), lit, features)

    def fill(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, lit: CausticLight, features: SceneFeatures,
             mean: wp.array) -> None:  # fmt: skip
        """Find what lies between the SPs; mean (1,): brightness of the picture."""
        edges, count = self._edges, self._count
        count.zero_()
        inputs = [gbuffer, sps.image, sps.sparse, sps.listed, mean, self._found, edges, count]
        launch_together(interpolate_caustics_kernel, sps.capacity, inputs, sps.device)
        self._gather(scene, gbuffer, (edges, count), lit, features)

    def _gather(self, scene: SceneData, gbuffer: GBuffer, listed: tuple[wp.array, wp.array], lit: CausticLight,
                features: SceneFeatures) -> None:  # fmt: skip
        device = self._found.device
        lanes = lanes_of(device, few=True)
        inputs = [scene, gbuffer, *listed, lit, lanes, self._found]
        launch(caustic_kernel(features), lanes * len(self._found), inputs, device)

    def add(self, gbuffer: GBuffer, radiance: wp.array) -> None:
        """Add to `radiance` (pixel,) what pixels reflect of caustics."""
        launch(reflect_caustics_kernel, len(radiance), [gbuffer, self._found, radiance], radiance.device)
