"""Where VPLs send light by the specular lobes of their surfaces, for frames that are right in the mean.

Clusters, and all that is read from how densely VPLs lie, take what a surface reflects as even.
"""

import warp as wp

from gpu.core.device import allocate, launch
from gpu.device_scene.bsdf import is_fibrous, is_grained, is_translucent
from gpu.device_scene.data import NO_HIT, WHOLE, SceneData
from gpu.device_scene.even_light import even_reflectance, focused_share, over_even
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import lifted
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface, surface_at
from gpu.lights.light_paths import Vpls
from gpu.vpl.vpl_reflectance import BELOW

# Lobes of VPLs are no narrower: each would be a bright spot where it points, which few frames show.
LEAST_ROUGHNESS = wp.constant(0.5)


@wp.struct
class VplLobes:
    """count: of VPLs, 0 where all send evenly. diffuse, f0, f90, roughness (vpl,): as gpu.device_scene.surface.Surface,
    f90 0 where one sends evenly.
    """

    count: int
    diffuse: wp.array[wp.vec3]
    f0: wp.array[wp.vec3]
    f90: wp.array[float]
    roughness: wp.array[float]


@wp.func
def sends_by_lobe(surface: Surface) -> bool:
    """Whether VPLs on a surface send by its lobe: not glass or what is translucent, nor below fibres or films,
    with a grain, or what casts caustics.
    """
    rare = surface.glass > 0.0 or surface.film > 0.0 or is_fibrous(surface) or is_grained(surface)
    rare = rare or is_translucent(surface)
    return surface.f90 > 0.0 and not rare and focused_share(surface) == 0.0


@wp.func
def by_lobe(lobes: VplLobes, vpls: Vpls, vpl: int, direction: wp.vec3) -> wp.vec3:
    """What a VPL sends along unit `direction` over what it would send there evenly."""
    share = wp.vec3(1.0, 1.0, 1.0)
    if lobes.count == 0:
        return share
    surface = Surface()
    surface.f90 = lobes.f90[vpl]
    if surface.f90 > 0.0:
        surface.normal = vpls.normal[vpl]
        surface.geometric_normal = surface.normal
        surface.diffuse = lobes.diffuse[vpl]
        surface.f0 = lobes.f0[vpl]
        surface.roughness = lobes.roughness[vpl]
        to_light = vpls.to_light[vpl]
        share = over_even(surface, to_light, direction, even_reflectance(surface, to_light))
    return share


@made_for(*LOOK)
def vpl_lobe_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def vpl_lobe_kernel(first: int, scene: SceneData, vpls: Vpls, lobes: VplLobes) -> None:
        """One thread a VPL: its surface's lobe."""
        vpl = first + wp.tid()
        scene = specialise(scene)
        scene.coverage = WHOLE
        lobes.f90[vpl] = 0.0
        normal = vpls.normal[vpl]
        hit = closest_hit(scene, lifted(vpls.position[vpl], normal), -normal, BELOW)
        if hit.face == NO_HIT:
            return
        surface = surface_at(scene, hit, -normal)
        if sends_by_lobe(surface):
            lobes.diffuse[vpl] = surface.diffuse
            lobes.f0[vpl] = surface.f0
            lobes.f90[vpl] = surface.f90
            lobes.roughness[vpl] = wp.max(surface.roughness, LEAST_ROUGHNESS)

    return vpl_lobe_kernel


def no_lobes() -> VplLobes:
    """Of VPLs that all send evenly."""
    lobes = VplLobes()
    lobes.count = 0
    return lobes


def lobes_of(scene: SceneData, features: SceneFeatures, vpls: Vpls) -> VplLobes:
    """Those of `vpls` on the surfaces of `scene`."""
    if scene.lambertian:
        return no_lobes()
    device = vpls.flux.device
    lobes: VplLobes = allocate(VplLobes, vpls.count, device)
    lobes.count = vpls.count
    launch(vpl_lobe_kernel(features), vpls.count, [scene, vpls, lobes], device)
    return lobes
