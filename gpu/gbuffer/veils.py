"""Veils, as surfaces that are there in part are called here: what of them cameras see whose chains are not drawn, and
what behind.

Such rays meet what is there by half or more, and cross the rest (gpu.device_scene.sides). At the first veil of a way
both are shown, each by its share; further ones are met whole or not at all, so that no light is lost.
"""

import warp as wp

from gpu.device_scene.data import NO_HIT, WHOLE, Hit, SceneData
from gpu.device_scene.panes import TintedHit
from gpu.device_scene.part_glass import part_at
from gpu.device_scene.rays import first_hit, nearer_in_part


@wp.struct
class VeiledHit:
    """What a branch shows: where it ends, and whether that is by way of a veil, which takes part of the light."""

    met: TintedHit
    veiled: bool


@wp.func
def past_veil(scene: SceneData, origin: wp.vec3, direction: wp.vec3, met: TintedHit, cull_backs: bool,
              other: bool) -> VeiledHit:  # fmt: skip
    """What a ray that crosses veils shows, if there is one before what it `met` and no pane is before that: what is
    behind, or the veil where that is but the sky, for there is nothing else to be shaded; the `other` branch has the
    rest.

    cull_backs: surfaces are not seen from behind where they can be culled.
    """
    scene.coverage = WHOLE
    shown = VeiledHit()
    shown.met = met
    veil = Hit()
    veil.face = NO_HIT
    veil.t = met.hit.t
    veil = nearer_in_part(scene, origin, direction, veil, cull_backs)  # all that is whole is no nearer
    if veil.face != NO_HIT and scene.pane_count > 0:
        pane = first_hit(scene.panes, origin, direction, veil.t, cull_backs)
        if pane.face != NO_HIT:
            veil.face = NO_HIT
    if veil.face != NO_HIT:
        part = part_at(scene, veil, direction)
        shown.veiled = part.there < 0.5  # else it is what the ray met, after all, by rounding
        if shown.veiled and (met.hit.face == NO_HIT) != other:
            shown.met.hit = veil
            shown.met.tint = wp.vec3(part.there, part.there, part.there)
        elif shown.veiled:
            shown.met.tint = met.tint * (1.0 - part.matt)
    return shown
