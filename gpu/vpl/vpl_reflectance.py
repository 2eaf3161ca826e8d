"""What surfaces reflect where VPLs lie, which VPLs themselves do not keep: of frosted glass, what of it is none."""

import warp as wp

from gpu.core.device import launch
from gpu.device_scene.bsdf import is_translucent, largest
from gpu.device_scene.data import NO_HIT, WHOLE, SceneData
from gpu.device_scene.even_light import even_reflectance, even_through, spread_reflectance
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import lifted
from gpu.device_scene.part_glass import is_part_glass, mean_direction, met_at, part_at
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.sides import LEAST_SHARE
from gpu.device_scene.specialisation import LOOK, made_for, specialisation

# A VPL's own surface is looked for no farther below it, in unit space.
BELOW = wp.constant(1.0e-4)


@wp.struct
class VplReflectance:
    """What the surface at a VPL reflects of even light, without frosted glass; spread: without what caustics have of
    light from emitters; through: of both, what is of light from behind; share: of the surface that is there.
    """

    even: wp.vec3
    spread: wp.vec3
    through: wp.vec3
    share: float


@wp.func
def reflectance_at(scene: SceneData, position: wp.vec3, normal: wp.vec3) -> VplReflectance:
    """That at a VPL; zero where there is no surface."""
    found = VplReflectance()
    found.share = 1.0
    scene.coverage = WHOLE
    hit = closest_hit(scene, lifted(position, normal), -normal, BELOW)
    if hit.face != NO_HIT:
        towards = -normal
        if scene.part_glass and is_part_glass(scene, hit.face):
            towards = mean_direction(normal)
        surface = met_at(scene, hit, towards)
        left = 1.0 - surface.glass
        counted = wp.where(surface.crossed, 1.0, left)  # mirrors count as matt
        found.even = even_reflectance(surface, normal) * counted
        found.spread = spread_reflectance(surface, normal, 1.0) * counted
        if is_translucent(surface):
            found.through = even_through(surface, normal) * left
        if scene.blended:
            found.share = wp.max(part_at(scene, hit, towards).there, LEAST_SHARE)
    return found


@wp.func
def reflectance_of_side(both: VplReflectance, choice: float) -> VplReflectance:
    """That of the side whose light a point sends on, by `choice`, uniform in [0, 1), where it sends that of `both`: the
    other one's is all `through`. The less often a side is chosen, the more it reflects.
    """
    front = both.even - both.through
    share = largest(both.through) / (largest(both.through) + largest(front))
    side = both
    if choice < share:
        side.through = both.through / share
        side.even = side.through
        side.spread = side.through
    else:
        side.even = front / (1.0 - share)
        side.spread = (both.spread - both.through) / (1.0 - share)
        side.through = wp.vec3(0.0, 0.0, 0.0)
    return side


@made_for(*LOOK)
def vpl_reflectance_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def vpl_reflectance_kernel(
        first: int,
        scene: SceneData,
        position: wp.array[wp.vec3],
        normal: wp.array[wp.vec3],
        reflectance: wp.array[wp.vec3],
        share: wp.array[float],
    ) -> None:
        """One thread a VPL at `position` with `normal`: what its surface reflects, and the share of it that is there,
        if anybody asks; all (vpl,).
        """
        vpl = first + wp.tid()
        scene = specialise(scene)
        found = reflectance_at(scene, position[vpl], normal[vpl])
        reflectance[vpl] = found.even
        if share.shape[0] > 0:
            share[vpl] = found.share

    return vpl_reflectance_kernel


def find_reflectance(scene: SceneData, features: SceneFeatures, position: wp.array, normal: wp.array,
                     reflectance: wp.array, share: wp.array) -> None:  # fmt: skip
    """Write what surfaces of `scene` reflect of even light at points with a `normal` into `reflectance`; (vpl,) each.

    Zero where there is no surface. share (vpl,), or empty: the share of the surface that is there.
    """
    inputs = [scene, position, normal, reflectance, share]
    launch(vpl_reflectance_kernel(features), len(position), inputs, position.device)
