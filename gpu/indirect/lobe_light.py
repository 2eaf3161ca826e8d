"""Light that rays of narrow lobes find, and how far pixels find the same.

A ray ends in the light that VPLs or photons know around its end. Mirrors, glass and narrow metal on its way send it on,
by a direction that is drawn.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from gpu.core.constants import PI
from gpu.core.image_size import ImageSize
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import all_diffuse, largest, traced_share
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.glass import attenuated
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import meet, met_surface
from gpu.device_scene.scattering import choose_part, part_of, sample_scattering
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.surface import Surface
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.illumination import IrradianceEstimate
from gpu.lights.background import background
from gpu.lights.light_sampling import light_at_hit
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import hashed, sobol_pair_at
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.radiosity_mean import mean_irradiance

# The sequences of `sobol_pair_at` that lobes take, from this one on, beside those of direct light and chains.
LOBE_PAIR = wp.constant(32)
# Of kernels that trace lobes' rays, as RAY_REGISTERS of others.
LOBE_REGISTERS = 96
# In place of a density: what emits counts elsewhere.
NO_EMISSION = wp.constant(-1.0)
# Of a ray into the surface itself, which others may still hear of.
NO_REACH = wp.constant(1.0e-6)


@wp.struct
@dataclass
class GlossParameters:
    """What pixels share of what their rays find.

    lobe_share: of a lobe's width where its ray ends, over which lobes are alike; plane_tolerance: how far off its plane
    a pixel still shows a surface, in its spacings a step; roughness_tolerance: roughness that differs by this is of
    another surface; most_of_brightest: of the light of the brightest pixel around; what is brighter is cut off.
    """

    lobe_share: float = 0.5
    plane_tolerance: float = 0.5
    roughness_tolerance: float = 0.05
    most_of_brightest: float = 2.0


GLOSS_PARAMETERS: GlossParameters = parameters(GlossParameters)


@dataclass(frozen=True)
class LobeRayParameters:
    """vertices: surfaces at the most that send a ray on; one more is shown matt, glass is crossed. Compiled in."""

    vertices: int = 5


LOBE_RAY_PARAMETERS = LobeRayParameters()
LOBE_VERTICES = wp.constant(LOBE_RAY_PARAMETERS.vertices)


@wp.struct
class LobeLight:
    """What rays of lobes find, (pixel,) each. light: of specular lobes over `even_specular` of the SP, of frosted glass
    as it is [W/m²/sr]; reach: of `lobe_reach`, 0 where there is no ray.
    """

    light: wp.array[wp.vec3]
    reach: wp.array[float]


@wp.func
def lobe_reach(gbuffer: GBuffer, pixel: int, camera: CameraData, image: ImageSize, distance: float,
               chosen: GlossParameters) -> float:  # fmt: skip
    """How far from a pixel's SP its lobe is about the same, where what it shows is at `distance`."""
    roughness = gbuffer.roughness[pixel]
    # Facets tilt by about α, light by twice that. Rays of pixels beside each other spread, too.
    width = 2.0 * roughness * roughness * distance
    if camera.orthographic:
        return chosen.lobe_share * width
    way = gbuffer.spacing[pixel] * float(image.height) / (2.0 * camera.half_height)
    return chosen.lobe_share * width * way / (way + distance)


@wp.struct
class KnownLight:
    """What rays of lobes end in. table: emitters that samples find; lit: what VPLs know; direct: whether emitters are
    seen through frosted glass; indirect: whether surfaces are, by what VPLs know; followed: whether chains that go on
    in lobes see these instead.
    """

    table: LightTable
    lit: RadiosityCache
    direct: bool
    indirect: bool
    followed: bool


def known_light(table: LightTable, lit: "RadiosityCache | None", *, direct: bool, photons: bool = False) -> KnownLight:
    """The struct of these; lit: None where there are no VPLs, or none are wanted; photons: whether these tell then."""
    known = KnownLight()
    known.table, known.lit, known.direct = table, lit or RadiosityCache(), direct
    known.indirect = photons or lit is not None
    return known


@wp.struct
class LobeRay:
    """A ray from a surface of `normal` (geometric) along unit `direction`. density: of this direction [1/sr], by which
    emitters are weighed against samples of them; 0: they count whole, NO_EMISSION: not at all. inside: whether it runs
    through a body, of this absorption. throughput: of what is seen along it, for its caller. place, index, seed: of
    its samples (gpu.sampling.sobol.sobol_pair_at).
    """

    position: wp.vec3
    normal: wp.vec3
    direction: wp.vec3
    density: float
    inside: bool
    absorption: wp.vec3
    throughput: wp.vec3
    place: int
    index: int
    seed: int


@wp.func
def lobe_ray(surface: Surface, direction: wp.vec3, density: float, place: int, index: int, seed: int) -> LobeRay:
    """A ray from `surface` along unit `direction`, outside of any body."""
    ray = LobeRay()
    ray.position = surface.position
    ray.normal = surface.geometric_normal
    ray.direction = direction
    ray.density = density
    ray.place = place
    ray.index = index
    ray.seed = seed
    return ray


@wp.struct
class SeenLight:
    """Light along a ray [W/m²/sr], and how far off the first surface is, 1 where there is none. Of a ray in a body, the
    first outside.
    """

    light: wp.vec3
    distance: float


@wp.func
def sends_on(part: Surface) -> bool:
    """Whether what the chosen part of a surface shows is sharp enough to be seen in lobes."""
    if part.glass > 0.0 or part.mirror:
        return True
    return largest(all_diffuse(part)) == 0.0 and traced_share(part.roughness, part.f90) > 0.0


@wp.func
def lobe_coverage(ray: LobeRay, vertex: int) -> wp.uint32:
    """A seed of BLEND that a ray meets on its way from its surface number `vertex`: a lamp behind it, or of it, counts
    in the mean what samples of lamps find.
    """
    return ray_coverage(ray.place, vertex, int(hashed(wp.uint32(ray.seed))) ^ ray.index)


@cache
def light_seen(lookup: wp.Function, data: Any) -> wp.Function:
    """The function that follows a ray; lookup, data: as of gpu.indirect.illumination.Illumination.

    seen(scene, known, lit, ray) has what is seen along `ray`, as `lit` tells it, a SeenLight.
    """

    @wp.func
    def seen_light(scene: SceneData, known: KnownLight, lit: data, ray: LobeRay) -> SeenLight:
        seen = SeenLight()
        seen.distance = 1.0
        throughput = wp.vec3(1.0, 1.0, 1.0)
        position = ray.position
        normal = ray.normal
        direction = ray.direction
        density = ray.density
        absorption = ray.absorption
        inside = ray.inside
        way = float(0.0)
        for vertex in range(LOBE_VERTICES + 1):
            if vertex == LOBE_VERTICES:
                scene.pane_count = 0
            scene.coverage = lobe_coverage(ray, vertex)
            origin = offset_origin(position, normal, direction)
            met = meet(scene, origin, direction, False)
            throughput = wp.cw_mul(throughput, met.tint)
            weight = float(1.0)
            if density > 0.0:
                found = light_at_hit(scene, known.table, known.table.all_emitters, origin, direction, met.hit)
                weight = density / (density + found.density)
            if met.hit.face == NO_HIT:
                if density >= 0.0:
                    seen.light += wp.cw_mul(throughput, background(scene, origin, direction)) * weight
                return seen
            way += met.hit.t
            if not inside and seen.distance == 1.0:
                seen.distance = way
            throughput = wp.cw_mul(throughput, attenuated(absorption, met.hit.t))
            surface = met_surface(scene, met.hit, direction)
            if density >= 0.0:
                seen.light += wp.cw_mul(throughput, surface.emission) * weight
            choice = sobol_pair_at(ray.place, ray.index, LOBE_PAIR + 2 * vertex + 1, ray.seed)
            chosen = choose_part(surface, -direction, choice.x)
            part = part_of(surface, chosen)
            if vertex == LOBE_VERTICES or not sends_on(part):
                if not known.indirect:
                    return seen
                arriving = lookup(lit, surface.position, surface.geometric_normal).irradiance
                reflected = wp.cw_mul(even_reflectance(part, -direction), arriving) / PI
                seen.light += wp.cw_mul(throughput, reflected)
                return seen
            point = sobol_pair_at(ray.place, ray.index, LOBE_PAIR + 2 * vertex + 2, ray.seed)
            sample = sample_scattering(part, -direction, chosen.rest, point.x, point.y)
            throughput = wp.cw_mul(throughput, sample.weight)
            if largest(throughput) <= 0.0:
                return seen
            if not (part.glass > 0.0 and part.clear):
                density = 0.0  # samples of emitters, which go straight through clear glass, find none by way of this
            if wp.dot(sample.direction, part.geometric_normal) < 0.0 and not part.thin:
                absorption = part.absorption
                inside = not inside
            position = part.position
            normal = part.geometric_normal
            direction = sample.direction
        return seen

    return seen_light


@wp.func
def irradiance_by_vpls(lit: RadiosityCache, position: wp.vec3, normal: wp.vec3) -> IrradianceEstimate:
    """The irradiance about a surface point, as VPLs tell it."""
    estimate = IrradianceEstimate()
    estimate.irradiance = mean_irradiance(lit, position, normal)
    estimate.known = True
    return estimate


seen_by_vpls = light_seen(irradiance_by_vpls, RadiosityCache)


@wp.func
def light_along(scene: SceneData, known: KnownLight, ray: LobeRay) -> SeenLight:
    """What is seen along a ray, as VPLs tell it."""
    return seen_by_vpls(scene, known, known.lit, ray)
