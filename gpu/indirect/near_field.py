"""Light that VPLs lose near field: a disk's form factor is less than that of the surface which it stands for.

A point light's 1/(π·d²) is bounded to 1/(π·d² + A), which takes the share A/(π·d² + A) away. It is given back by a ray
of each SP: where that meets a surface, its radiosity counts with this share (T. Kollig and A. Keller, Illumination in
the Presence of Weak Singularities, 2004, with radiosity from a density estimate in place of a path).
"""

from functools import cache

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import allocate, launch
from gpu.denoise.atrous import Smoothing
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import blocking, closest_hit, offset_origin
from gpu.device_scene.surface import triangle_normal
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.form_factor import disk_area
from gpu.vpl.radiosity_cache import RadiosityCache, vpl_around
from gpu.vpl.vpl_clusters import VplClusters

# Of the sample sequences of a frame's seed, one that nothing else takes.
NEAR_PAIR = wp.constant(64)
# VPLs whose radius is far below this share of the distance lose too little to be looked for.
RADIUS_SHARE = wp.constant(0.06)
# Of the scene's extent: farther than this, the rays of one SP in so many look, and count as often. What is found there
# is little and much the same for neighbours.
NEAR_LENGTH = wp.constant(0.05)
FAR_EVERY = wp.constant(4)
# Of the SPs whose light earlier frames found, too, one in so many has a ray, which counts as often.
KNOWN_EVERY = wp.constant(3)
# How far above its surface the way between two of its points is looked along, as a share of its length.
CLEARANCE = wp.constant(0.1)


@wp.struct
class Hits:
    """What the SPs' rays met. position, normal (sp,), the normal to the side that was hit; distance (sp,): 0 for none.

    Unit space.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    distance: wp.array[float]


@wp.func
def ray_period(frames: int) -> int:
    """One in how many SPs whose light is known of so many `frames` before has a ray; another in the next frame."""
    return wp.where(frames > 0, KNOWN_EVERY, 1)


@cache
def near_field_ray_kernel(alpha: bool) -> wp.Kernel:
    """The kernel that traces the rays; alpha: whether these must look at masks."""

    @wp.kernel(module="unique")
    def near_field_ray_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        seed: wp.array[int],
        frames: wp.array[int],
        hits: Hits,
    ) -> None:
        """One thread an SP: a ray with density cosθ/π. SPs, whose order keeps neighbours together, share a sequence."""
        sp = first + wp.tid()
        hits.distance[sp] = 0.0
        if sp >= points.count[0]:
            return
        if wp.static(not alpha):
            scene.ignore_alpha = True
        pixel = points.pixels[sp]
        every = ray_period(frames[pixel])
        if (sp + seed[0]) % every != 0:
            return
        place = sobol_pair(sp, NEAR_PAIR, seed[0])
        direction = cosine_direction(gbuffer.normal[pixel], place.x, place.y)
        geometric_normal = gbuffer.geometric_normal[pixel]
        if wp.dot(direction, geometric_normal) <= 0.0:
            return
        origin = offset_origin(gbuffer.position[pixel], geometric_normal, direction)
        looks_far = (sp + seed[0]) % (FAR_EVERY * every) == 0
        length = wp.where(looks_far, RAY_LENGTH, NEAR_LENGTH)
        hit = closest_hit(scene, origin, direction, length)
        if hit.face == NO_HIT:
            return
        normal = triangle_normal(scene, hit.face)
        hits.position[sp] = origin + direction * hit.t
        hits.normal[sp] = wp.where(wp.dot(normal, direction) < 0.0, normal, -normal)
        hits.distance[sp] = hit.t

    return near_field_ray_kernel


@wp.kernel
def near_field_vpl_kernel(first: int, hits: Hits, lit: RadiosityCache, vpl: wp.array[int]) -> None:
    """One thread an SP: the VPL that answers for where its ray went. vpl (sp,): −1 for none."""
    sp = first + wp.tid()
    vpl[sp] = -1
    distance = hits.distance[sp]
    if distance > 0.0:
        vpl[sp] = vpl_around(lit, hits.position[sp], hits.normal[sp], RADIUS_SHARE * distance)


@cache
def near_field_light_kernel(blocked: wp.Function) -> wp.Kernel:
    """The kernel that looks along the surface with `blocked`, one of gpu.device_scene.rays.occluded and
    occluded_solid.
    """

    @wp.func
    def is_apart(scene: SceneData, position: wp.vec3, normal: wp.vec3, other: wp.vec3, distance: float) -> bool:
        way = other - position
        length = wp.length(way)
        if length == 0.0:
            return False
        lift = normal * wp.min(CLEARANCE * length, 0.5 * distance)
        return blocked(scene, position + lift, way / length, length)

    @wp.kernel(module="unique")
    def near_field_light_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        hits: Hits,
        vpls: VplClusters,
        lit: RadiosityCache,
        frames: wp.array[int],
        vpl: wp.array[int],
        light: wp.array[wp.vec3],
        found: wp.array[int],
    ) -> None:
        """One thread an SP: the irradiance that disks took from where its ray went [W/m²], in light (pixel,).

        Where something stands between that point and the VPL, as a wall on a floor does, what the VPL knows is not so
        there. found (sp,): 1 where there is light, or 0.
        """
        sp = first + wp.tid()
        found[sp] = 0
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        light[pixel] = wp.vec3(0.0, 0.0, 0.0)
        near = vpl[sp]
        distance = hits.distance[sp]
        if near >= 0 and not is_apart(scene, hits.position[sp], hits.normal[sp], lit.position[near], distance):
            squared = distance * distance
            area = disk_area(gbuffer.position[pixel], vpls, near)
            share = float(ray_period(frames[pixel])) * area / (PI * squared + area)
            if distance > NEAR_LENGTH:
                share *= float(FAR_EVERY)
            light[pixel] = lit.radiosity[near] * share
            found[sp] = 1

    return near_field_light_kernel


class NearField:
    """Near-field light of the SPs of an image of `size` (width, height); arrays are allocated once.

    light (pixel,): what each SP's ray found [W/m²]; found (sp,): 1 where that is some, or 0.
    """

    def __init__(self, capacity: int, smoothing: Smoothing, device: wp.Device) -> None:
        self.device, self._smoothing = device, smoothing
        self._hits: Hits = allocate(Hits, capacity, device)
        self._vpl = wp.zeros(capacity, dtype=int, device=device)
        self.light = wp.zeros(capacity, dtype=wp.vec3, device=device)
        self.found = wp.zeros(capacity, dtype=int, device=device)

    def trace(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, lit: RadiosityCache,
              seed: wp.array, frames: wp.array) -> None:  # fmt: skip
        """Estimate the irradiance of `sps` that the disks of `vpls`, from which `lit` is, have lost.

        seed: (1,); frames (pixel,): of how many earlier frames the light of each is known.
        """
        capacity, points, hits = sps.capacity, (scene, gbuffer, sps.points), self._hits
        launch(near_field_ray_kernel(scene.alpha), capacity, [*points, seed, frames, hits], self.device)
        launch(near_field_vpl_kernel, capacity, [hits, lit, self._vpl], self.device)
        inputs = [*points, hits, vpls, lit, frames, self._vpl, self.light, self.found]
        launch(near_field_light_kernel(blocking(scene)), capacity, inputs, self.device)

    def share(self, gbuffer: GBuffer, sps: ShadingPoints, guide: wp.array, frames: wp.array) -> None:
        """Share `light`, known of so many earlier `frames`, between neighbours of one surface, guided by other light.

        As gpu.denoise.atrous does; (pixel,) each.
        """
        wp.copy(self.light, self._smoothing.share(gbuffer, sps, guide, self.light, frames, nearer_on_detail=False))
