"""Veils, as surfaces of BLEND are called here: what of them cameras see whose chains are not drawn, and what behind.

Such rays meet what is there by half or more, and cross the rest (gpu.device_scene.sides). At the first veil of a way
both are shown, each by its share; further ones are met whole or not at all, so that no light is lost.
"""

import warp as wp

from gpu.device_scene.data import NO_HIT, WHOLE, Hit, SceneData
from gpu.device_scene.rays import first_hit, first_surface
from gpu.device_scene.sides import solid_share


@wp.struct
class Veil:
    """Where a ray crosses a veil, and the share of it that is there; hit.face is NO_HIT where there is none."""

    hit: Hit
    share: float


@wp.func
def crossed_veil(scene: SceneData, origin: wp.vec3, direction: wp.vec3, max_t: float, cull_backs: bool) -> Veil:
    """The first veil before `max_t`, where a ray that crosses veils meets something, if no pane is before it.

    cull_backs: surfaces are not seen from behind where they can be culled.
    """
    scene.coverage = WHOLE
    veil = Veil()
    veil.hit = first_surface(scene, origin, direction, max_t, cull_backs)
    if veil.hit.face != NO_HIT and scene.pane_count > 0:
        pane = first_hit(scene.panes, origin, direction, veil.hit.t, cull_backs)
        if pane.face != NO_HIT:
            veil.hit.face = NO_HIT
    if veil.hit.face != NO_HIT:
        veil.share = solid_share(scene, veil.hit.face, veil.hit.u, veil.hit.v)
        if veil.share >= 0.5:
            veil.hit.face = NO_HIT  # what the ray meets, after all, by rounding
    return veil
