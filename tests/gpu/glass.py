"""Mirrors and clear glass for tests, and the caustic photons that they send on."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import warp as wp
from scenes import box, grey, quad, resident_of
from trimesh.creation import icosphere

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.caustic_casters import caustic_casters
from gpu.lights.caustic_map import CausticMap
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Environment, Floats, Light, LightKind, Material

MIRROR = Material(metallic=1.0, roughness=0.0)
GLASS = Material(transmission=1.0, roughness=0.0, thickness=1.0)
EVEN = Environment("even", np.ones((4, 8, 3), np.float32))
FLOOR = quad([-0.5, -0.25, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)


def ball(radius: float = 0.1) -> MeshPart:
    """A smooth one about the origin, of the first material."""
    mesh = icosphere(3, radius)
    points = np.asarray(mesh.vertices)
    return MeshPart(points, np.asarray(mesh.faces), normals=points / radius)


def cube(half: float = 0.1) -> list[MeshPart]:
    """One about the origin, of the first material, whose fronts are outside."""
    return [MeshPart(part.positions, part.triangles[:, ::-1]) for part in box(0, half)]


def bulb(*position: float, intensity: float = 1.0) -> Light:
    """A point light."""
    return Light("bulb", LightKind.POINT, (intensity,) * 3, position=position)


def mirror_over_floor(*lights: Light, parts: Sequence[MeshPart] = (), roughness: float = 0.0) -> DeviceScene:
    """A mirror of 0.2 by 0.2 that lies in the middle of a room, facing down, over the room's floor; parts: more;
    roughness: of metal instead. It is shown by general kernels, which other tests compile as well.
    """
    mirror = quad([-0.1, 0.0, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 0)
    materials = [replace(MIRROR, roughness=roughness), grey(0.5)]
    return resident_of([mirror, *box(1), *parts], materials, lights=list(lights)).generalised()


def caustics_of(
    device_scene: DeviceScene, paths: int, bounces: int = 4, seed: int = 0, share: float = 1.0
) -> CausticMap:
    """The caustic map of a scene; share: of the width of its estimates."""
    caustics = CausticMap(paths, bounces, device_scene.device)
    caustics.light.share.fill_(share)
    features = device_scene.generalised().features(lambertian=False)
    seeds = wp.full(1, seed, dtype=int, device=device_scene.device)
    scene, table = device_scene.view(lambertian=False), build_light_table(device_scene)
    caustics.trace(scene, table, caustic_casters(device_scene), seeds, features)
    return caustics


def photons_in(caustics: CausticMap) -> tuple[Floats, Floats, Floats]:
    """Positions, normals and fluxes of its photons."""
    photons, count = caustics.light.tree.photons, int(caustics.count.numpy()[0])
    return tuple(array.numpy()[:count] for array in (photons.position, photons.normal, photons.flux))  # type: ignore[return-value]
