"""A scene at a time of one of its animations.

What a scene's box, its unit space, its chosen view and added light are is decided by the pose that its file has without
animation: they do not change with time, and what moves may leave the box.
"""

from dataclasses import replace

import numpy as np

from gpu.errors import UserError
from gpu.scene.animation.motion import NODE_PROPERTIES, STILL, Animation, Body, Motion
from gpu.scene.animation.pose import Pose, at_rest, in_world, pose_at
from gpu.scene.animation.posed_look import with_look
from gpu.scene.geometry.normals import area_vectors, repaired_normals
from gpu.scene.geometry.soundness import sound
from gpu.scene.pauses import Pause, go_on
from gpu.scene.scene_parts import MeshPart
from gpu.scene.to_world import matrix_in_world, placed_light
from gpu.scene.transforms import mirrored, rigid
from gpu.scene.types import Camera, Doubles, Floats, Integers, Ints, Light, Mask, Scene

_FARTHEST = 1e6  # times the size of the scene


@np.errstate(over="ignore", invalid="ignore")  # of what is too far away, which is said
def posed(scene: Scene, motion: Motion, animation: Animation, time: float, pause: Pause = go_on) -> Scene:
    """`scene`, whose `motion` has that animation, at a `time` [s] of it; after its end it stays as it is there.

    pause: called between steps that take long. Raises UserError, which names the field, where it takes something too
    far away or leaves nothing to see.
    """
    pose = pose_at(motion, animation, time, pause)
    if any(channel.changes in NODE_PROPERTIES for channel in animation.channels):
        scene = _moved(scene, motion, pose, time, pause)
    dark = [index for index, node in enumerate(motion.lights) if node in pose.hidden]
    return with_look(scene, motion, animation, time, dark, pause)


def _moved(scene: Scene, motion: Motion, pose: Pose, time: float, pause: Pause) -> Scene:
    """`scene` with what moves with nodes where that is in `pose`, and without meshes that are hidden."""
    rest = at_rest(motion, pause)
    vertices, normals, triangles = scene.vertices, scene.normals, scene.triangles
    gone = []
    for body, faces in scene.body_triangles:
        pause()
        own = slice(body.first_vertex, body.first_vertex + len(body.vertices))
        local = triangles[faces] - body.first_vertex
        over = _turned_over(local, body, rest, pose)
        if over.any():
            local = np.where(over[:, None], local[:, ::-1], local)
            triangles = triangles.copy() if triangles is scene.triangles else triangles
            triangles[faces] = local + body.first_vertex
        found = in_world(MeshPart(body.positions, body.triangles, body.normals), body, pose)
        positions = found.positions[body.vertices]
        turned = _flat(positions, local) if found.normals is None else found.normals[body.vertices]
        unit = _in_unit_space(scene, positions)
        _check_near(unit, time)
        there = unit.astype(np.float32)
        vertices = _with_part(vertices, scene.vertices, own, there)
        repaired = repaired_normals(scene.frame.turned(turned), there, local)
        normals = _with_part(normals, scene.normals, own, repaired)
        lost = ~sound(there.astype(np.float64), local) | (body.node in pose.hidden)
        gone.append(faces.start + np.flatnonzero(lost))
    material, lost = scene.triangle_material, np.concatenate(gone) if gone else np.zeros(0, np.intp)
    if len(lost) == len(triangles):
        raise UserError(f"time: at {time:g} s nothing of the scene is visible and has an area")
    if len(lost):
        triangles, material = np.delete(triangles, lost, axis=0), np.delete(material, lost)
    for node in {*motion.lights, *motion.cameras} - {STILL}:
        _check_near(_in_unit_space(scene, pose.to_world[node, :3, 3]), time)
    return replace(
        scene,
        vertices=vertices,
        normals=normals,
        triangles=triangles,
        triangle_material=material,
        lights=_lights(scene, motion, pose),
        cameras=_cameras(scene, motion, pose),
    )


def _in_unit_space(scene: Scene, positions: Doubles) -> Doubles:
    """Positions (…, 3) of the file in the scene's unit space."""
    return (scene.frame.to_world(positions) - scene.placement.centre) * scene.placement.scale


def _check_near(unit: Doubles, time: float) -> None:
    """Raise UserError where something, in unit space, is too far away, or nowhere."""
    if not np.abs(unit).max() < _FARTHEST:
        raise UserError(f"time: at {time:g} s the animation takes things farther than can be shown")


def _with_part(now: Floats, before: Floats, own: slice, part: Floats) -> Floats:
    """`now` with `part` of it from elsewhere. It is the array `before` itself as long as all is as in that, so that it
    is known to be the same.
    """
    if now is before:
        if np.array_equal(part, before[own]):
            return now
        now = before.copy()
    now[own] = part
    return now


def _turned_over(triangles: Ints, body: Body, rest: Pose, pose: Pose) -> Mask:
    """Which of `triangles` (triangle, 3) of `body` are to be the other way round: it is mirrored now and was not, or
    was.
    """
    if body.skin is not None:
        return np.zeros(len(triangles), bool)
    before, now = (mirrored(one.to_world[body.node] @ body.instances) for one in (rest, pose))
    return np.asarray((before != now)[body.vertices[triangles[:, 0]] // len(body.positions)])


def _flat(positions: Doubles, triangles: Integers) -> Doubles:
    """The normal (vertex, 3) of each vertex's only triangle."""
    normals = np.zeros_like(positions)
    normals[triangles] = area_vectors(positions, triangles)[:, None]
    return normals


def _lights(scene: Scene, motion: Motion, pose: Pose) -> tuple[Light, ...]:
    lights = list(scene.lights)
    for index, node in enumerate(motion.lights):
        if node != STILL:
            axes = rigid(pose.to_world[node])
            lights[index] = placed_light(lights[index], axes[:3, 3], -axes[:3, 2], scene.frame, scene.placement)
    return tuple(lights)


def _cameras(scene: Scene, motion: Motion, pose: Pose) -> tuple[Camera, ...]:
    cameras = list(scene.cameras)
    for index, node in enumerate(motion.cameras):
        if node != STILL:
            cameras[index] = replace(cameras[index], to_world=matrix_in_world(rigid(pose.to_world[node]), scene.frame))
    return tuple(cameras)
