"""Sides and alpha of surfaces: decided here, for camera rays, light paths, light samples and shadow rays alike.

- The front of a triangle is the side that it is wound counter-clockwise on (glTF 2.0, 3.7.2.1).
- What alpha cuts away is not there: it is not seen, stops no light and emits none (3.9.4). Of BLEND a share of alpha is
  there: light of lamps is dimmed by it, other rays meet it at random, and cameras that do not draw from one half on
  (gpu.gbuffer.veils).
- Light meets both sides of every surface, and both reflect alike: no wall leaks, whichever way it is turned.
- A camera does not see the backs of one-sided surfaces (3.9.5), so that a room is seen from outside.
- Two-sided surfaces emit from both sides, all others from the front.
"""

import warp as wp

from gpu.device_scene.data import HALF, WHOLE, SceneData
from gpu.device_scene.textures import sample_alpha
from gpu.sampling.sobol import hashed

# A share of a surface that is less is not there at all, for rays that meet BLEND as if it were whole.
LEAST_SHARE = wp.constant(1.0 / 256.0)


@wp.func
def triangle_normal(scene: SceneData, face: int) -> wp.vec3:
    """Unit normal of a triangle's front."""
    corner = scene.triangles[face]
    p0 = scene.vertices[corner[0]]
    return wp.normalize(wp.cross(scene.vertices[corner[1]] - p0, scene.vertices[corner[2]] - p0))


@wp.func
def ray_coverage(index: int, pair: int, seed: int) -> wp.uint32:
    """A seed for what a ray meets at random (SceneData.coverage): its path's and pair's own, not 0."""
    return hashed(wp.uint32(index) ^ hashed(wp.uint32(pair) ^ hashed(wp.uint32(seed)))) | wp.uint32(1)


@wp.func
def layer_sample(scene: SceneData, face: int, u: float, v: float) -> float:
    """A uniform number in (0, 1] of a ray's crossing of a triangle: another at each place, the same when asked again.

    `scene.coverage` is the ray's own.
    """
    place = wp.cast(u, wp.uint32) ^ hashed(wp.cast(v, wp.uint32) ^ wp.uint32(face))
    return float(hashed(scene.coverage ^ hashed(place)) >> wp.uint32(8)) * (1.0 / 16777216.0) + (0.5 / 16777216.0)


@wp.func
def has_alpha(scene: SceneData, face: int) -> bool:
    """Whether alpha tells what there is of a triangle."""
    first = scene.opaque_count + scene.pane_count
    return not scene.ignore_alpha and face >= first and face < first + scene.masked_count


@wp.func
def is_solid(scene: SceneData, face: int, u: float, v: float) -> bool:
    """Whether a ray finds something at barycentrics (u, v) of a triangle, or alpha has cut it away."""
    if not has_alpha(scene, face):
        return True
    cutoff = scene.materials[scene.triangle_material[face]].alpha_cutoff
    if scene.coverage != HALF and scene.materials[scene.triangle_material[face]].blend:
        cutoff = wp.where(scene.coverage == WHOLE, LEAST_SHARE, layer_sample(scene, face, u, v))
    return sample_alpha(scene, face, u, v) >= cutoff


@wp.func
def solid_share(scene: SceneData, face: int, u: float, v: float) -> float:
    """The share of a triangle that is there at its barycentrics: all, nothing, or alpha where that is BLEND."""
    if not has_alpha(scene, face):
        return 1.0
    material = scene.materials[scene.triangle_material[face]]
    alpha = sample_alpha(scene, face, u, v)
    if material.blend:
        return wp.clamp(alpha, 0.0, 1.0)
    return wp.where(alpha >= material.alpha_cutoff, 1.0, 0.0)


@wp.func
def emits_from_back(scene: SceneData, face: int) -> bool:
    """Whether a triangle emits from its back as it does from its front."""
    return scene.materials[scene.triangle_material[face]].double_sided


@wp.func
def emitting_normal(scene: SceneData, face: int, to_viewer: wp.vec3) -> wp.vec3:
    """Unit normal of the side of a triangle that may emit to whoever is in the direction `to_viewer`.

    The front's where the back does not emit; that points away from a viewer behind it.
    """
    normal = triangle_normal(scene, face)
    if wp.dot(normal, to_viewer) < 0.0 and emits_from_back(scene, face):
        return -normal
    return normal
