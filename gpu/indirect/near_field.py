"""Light that VPLs lose near field: a disk's form factor is less than that of the surface which it stands for.

A point light's 1/(π·d²) is bounded to 1/(π·d² + A), which takes the share A/(π·d² + A) away. It is given back by a ray
of each SP: where that meets a surface, its radiosity counts with this share (T. Kollig and A. Keller, Illumination in
the Presence of Weak Singularities, 2004, with radiosity from a density estimate in place of a path, where there is
one).
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import allocate, launch
from gpu.core.parameters import parameters
from gpu.denoise.atrous import Smoothing
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint
from gpu.device_scene.rays import blocking, closest_hit
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.specialisation import cutouts_of, made_for, masks_of, ray_registers, specialisation
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.near_field_paths import NearPaths, near_field_path_kernel
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.vpl.form_factor import disk_area
from gpu.vpl.radiosity_cache import RadiosityCache, is_narrow, lacking_area, vpl_around
from gpu.vpl.radiosity_reach import is_apart_of
from gpu.vpl.vpl_clusters import VplClusters

# Of the sample sequences of a frame's seed, one that nothing else takes.
NEAR_PAIR = wp.constant(64)
TINT_PAIR = wp.constant(63)


@wp.struct
@dataclass
class NearFieldParameters:
    """Where near-field light is looked for.

    radius_share: VPLs whose radius is far below this share of the distance lose too little to be looked for.
    near_length: farther than this, in unit space, only one ray in far_period looks, and counts as often: what is found
    there is little and much the same for neighbours.
    known_period: of the SPs whose light earlier frames found, one in so many has a ray, which counts as often.
    clearance: how far above its surface the way between two of its points is traced, as a share of its length.
    usual_share: where no VPL tells the radiosity, rays go on; those that count for less do so by chance, and then count
    for as much. most_usual_area: of VPLs (RadiosityCache), that of 6,400; where there are fewer, no ray goes on: so
    much would be found by paths that single ones were seen.
    """

    radius_share: float = 0.06
    near_length: float = 0.05
    far_period: int = 4
    known_period: int = 3
    clearance: float = 0.1
    usual_share: float = 0.1
    most_usual_area: float = 2.5e-3


NEAR_FIELD_PARAMETERS: NearFieldParameters = parameters(NearFieldParameters)


@wp.struct
class NearRays:
    """What the SPs' rays met and found; (sp,) but for `light`. Unit space.

    position, normal: of the surface, to the side that was hit; distance: 0 for none; vpl: that answers there, −1 for
    none; share: of the radiosity there that the SP lacks, where no VPL tells it and the ray goes on, else 0; light
    (pixel,): the irradiance that disks took from there [W/m²]; found: 1 where there is some, or 0.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    distance: wp.array[float]
    vpl: wp.array[int]
    share: wp.array[float]
    light: wp.array[wp.vec3]
    found: wp.array[int]


@wp.func
def are_many(lit: RadiosityCache, chosen: NearFieldParameters) -> bool:
    """Whether there are so many VPLs that rays go on where these tell nothing."""
    return lit.usual_area <= chosen.most_usual_area


@wp.func
def ray_period(frames: int, chosen: NearFieldParameters) -> int:
    """One in how many SPs whose light is known of so many `frames` before has a ray; another in the next frame."""
    return wp.where(frames > 0, chosen.known_period, 1)


@made_for("masks", "alpha", "cutouts", "part_glass")
def near_field_ray_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", cuda_max_registers=ray_registers(features))
    def near_field_ray_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        seed: wp.array[int],
        frames: wp.array[int],
        chosen: NearFieldParameters,
        rays: NearRays,
    ) -> None:
        """One thread an SP: a ray with density cosθ/π. SPs, whose order keeps neighbours together, share a sequence.

        seed: (1,); frames (pixel,): of how many earlier frames the light of each is known.
        """
        sp = first + wp.tid()
        rays.distance[sp] = 0.0
        if sp >= points.count[0]:
            return
        scene = specialise(scene)
        pixel = points.pixels[sp]
        every = ray_period(frames[pixel], chosen)
        if (sp + seed[0]) % every != 0:
            return
        place = sobol_pair(sp, NEAR_PAIR, seed[0])
        direction = cosine_direction(gbuffer.normal[pixel], place.x, place.y)
        geometric_normal = gbuffer.geometric_normal[pixel]
        if wp.dot(direction, geometric_normal) <= 0.0:
            return
        origin = offset_origin(gbuffer.position[pixel], geometric_normal, direction)
        looks_far = (sp + seed[0]) % (chosen.far_period * every) == 0
        length = wp.where(looks_far, RAY_LENGTH, chosen.near_length)
        hit = closest_hit(scene, origin, direction, length)
        if hit.face == NO_HIT:
            return
        if scene.part_glass:
            tint = crossed_tint(scene, origin, direction, hit.t, False)
            if sobol_pair(sp, TINT_PAIR, seed[0]).x > (tint[0] + tint[1] + tint[2]) / 3.0:
                return  # as much as is absorbed, of all colours
        normal = triangle_normal(scene, hit.face)
        rays.position[sp] = origin + direction * hit.t
        rays.normal[sp] = wp.where(wp.dot(normal, direction) < 0.0, normal, -normal)
        rays.distance[sp] = hit.t

    return near_field_ray_kernel


@wp.kernel
def near_field_vpl_kernel(first: int, lit: RadiosityCache, chosen: NearFieldParameters, rays: NearRays) -> None:
    """One thread an SP: the VPL that answers for where its ray went, or the area that one would have, in `share`."""
    sp = first + wp.tid()
    rays.vpl[sp] = -1
    rays.share[sp] = 0.0
    distance = rays.distance[sp]
    if distance <= 0.0:
        return
    scale = chosen.radius_share * distance
    vpl = vpl_around(lit, rays.position[sp], rays.normal[sp], scale)
    rays.vpl[sp] = vpl
    if vpl < 0 and are_many(lit, chosen):
        rays.share[sp] = lacking_area(lit, rays.position[sp], rays.normal[sp], scale)


@made_for("cutouts", "part_glass")
def near_field_light_kernel(features: SceneFeatures, blocked: wp.Function) -> wp.Kernel:
    """The kernel that looks along the surface with `blocked`, as of is_apart_of."""
    specialise, is_apart = specialisation(features), is_apart_of(blocked)

    @wp.kernel(module="unique", cuda_max_registers=ray_registers(features))
    def near_field_light_kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        points: PointList,
        vpls: VplClusters,
        lit: RadiosityCache,
        frames: wp.array[int],
        chosen: NearFieldParameters,
        rays: NearRays,
    ) -> None:
        """One thread an SP: the irradiance that disks took from where its ray went.

        Where something stands between that point and the VPL, as a wall on a floor does, what the VPL knows is not so
        there. frames: as of the rays.
        """
        if wp.static(features.part_glass or not features.cutouts):
            scene = specialise(scene)
        sp = first + wp.tid()
        rays.found[sp] = 0
        if sp >= points.count[0]:
            return
        pixel = points.pixels[sp]
        rays.light[pixel] = wp.vec3(0.0, 0.0, 0.0)
        near = rays.vpl[sp]
        distance = rays.distance[sp]
        if distance <= 0.0:
            return
        seen_from = gbuffer.position[pixel]
        area = rays.share[sp]
        known = bool(False)
        goes_on = are_many(lit, chosen)
        if near >= 0:
            area = disk_area(seen_from, vpls, near)
            if not (goes_on and is_narrow(lit, near)):
                place = rays.position[sp]
                known = not is_apart(scene, place, rays.normal[sp], seen_from, lit.position[near], chosen.clearance)
        share = float(ray_period(frames[pixel], chosen)) * area / (PI * distance * distance + area)
        if distance > chosen.near_length:
            share *= float(chosen.far_period)
        if known:
            rays.light[pixel] = lit.radiosity[near] * share
            rays.found[sp] = 1
        elif goes_on:
            rays.share[sp] = share

    return near_field_light_kernel


class NearField:
    """Near-field light of up to `capacity` SPs, one a pixel at the most; arrays are allocated once.

    light (pixel,): what each SP's ray found [W/m²]; found (sp,): 1 where that is some, or 0.
    """

    def __init__(self, capacity: int, smoothing: Smoothing, device: wp.Device, table: LightTable,
                 features: SceneFeatures, bounces: int,
                 chosen: NearFieldParameters = NEAR_FIELD_PARAMETERS) -> None:  # fmt: skip
        """table: of the emitters; features: the scene's; bounces: the most surfaces that light meets before an SP."""
        self.device, self._smoothing, self._chosen = device, smoothing, chosen
        self._table, self._features = table, features
        self._rays: NearRays = allocate(NearRays, capacity, device, pauses=True)
        self.light, self.found = self._rays.light, self._rays.found
        self._paths = paths = NearPaths()
        paths.bounces, paths.usual_share = bounces, chosen.usual_share
        paths.radius_share, paths.clearance = chosen.radius_share, chosen.clearance
        paths.position, paths.normal, paths.share = self._rays.position, self._rays.normal, self._rays.share

    def trace(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, vpls: VplClusters, lit: RadiosityCache,
              seed: wp.array, frames: wp.array) -> None:  # fmt: skip
        """Estimate the irradiance of `sps` that the disks of `vpls`, from which `lit` is, have lost.

        seed: (1,); frames (pixel,): of how many earlier frames the light of each is known.
        """
        capacity, points, rays, chosen = sps.capacity, (scene, gbuffer, sps.points), self._rays, self._chosen
        launch(near_field_ray_kernel(masks_of(scene)), capacity, [*points, seed, frames, chosen, rays], self.device)
        launch(near_field_vpl_kernel, capacity, [lit, chosen, rays], self.device)
        inputs = [*points, vpls, lit, frames, chosen, rays]
        launch(near_field_light_kernel(cutouts_of(scene), blocking(scene)), capacity, inputs, self.device)
        inputs = [scene, self._table, lit, sps.points.pixels, seed, self._paths, rays.light, rays.found]
        launch(near_field_path_kernel(self._features, blocking(scene)), capacity, inputs, self.device)

    def share(self, gbuffer: GBuffer, sps: ShadingPoints, guide: wp.array, frames: wp.array) -> None:
        """Share `light`, known of so many earlier `frames`, between neighbours of one surface, guided by other light.

        As gpu.denoise.atrous does; (pixel,) each.
        """
        wp.copy(self.light, self._smoothing.share(gbuffer, sps, guide, self.light, frames, nearer_on_detail=False))
