"""Small scenes for the renderer's tests, and kernels' results as arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.lights.light_table import LightTable
from gpu.lights.path_ends import PathEnds, gather_vpls_kernel, paths_for
from gpu.scene.assemble import assemble
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Camera, Doubles, Environment, Light, Material, Scene, Sky, Texture


def quad(corner: Sequence[float], edge_u: Sequence[float], edge_v: Sequence[float], material: int = 0) -> MeshPart:
    """A parallelogram whose front is edge_u × edge_v; UVs (0, 0) at `corner`, (1, 1) opposite it."""
    origin, u, v = (np.asarray(vector, np.float64) for vector in (corner, edge_u, edge_v))
    positions = np.stack([origin, origin + u, origin + u + v, origin + v])
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
    return MeshPart(positions, np.array([[0, 1, 2], [0, 2, 3]]), uvs=(uvs,), material=material)


def box(material: int = 0, half: float = 0.5) -> list[MeshPart]:
    """A closed cube about the origin whose fronts are inside."""
    parts = []
    for axis in range(3):
        for side in (-half, half):
            corner, u, v = np.full(3, -half), np.zeros(3), np.zeros(3)
            corner[axis] = side
            u[(axis + 1) % 3], v[(axis + 2) % 3] = 2.0 * half, 2.0 * half
            parts.append(quad(corner, u, v, material) if side < 0.0 else quad(corner, v, u, material))
    return parts


def grey(albedo: float, emission: float = 0.0) -> Material:
    """A rough dielectric without a specular lobe."""
    return Material(base_color=(albedo, albedo, albedo, 1.0), emission=(emission,) * 3, specular=0.0)


# Kernels are compiled for what is rare and in a scene. Tests of such surfaces have these among the materials of theirs,
# of nothing that is there, so that all are shown by the same ones.
RARE = (
    Material(transmission=1.0, roughness=0.4),
    Material(clearcoat=1.0),
)


def scene_of(
    parts: Sequence[MeshPart],
    materials: Sequence[Material],
    lights: Sequence[Light] = (),
    sky: Sky | Environment | None = None,
    textures: Sequence[Texture] = (),
) -> Scene:
    """The parts as a scene. Its unit space is the world where the parts fill [−½, ½]³ along one axis, centred."""
    return assemble("test", SceneParts(parts, materials, textures, lights, sky=sky, up="y", metres_per_unit=1.0))


def resident_of(
    parts: Sequence[MeshPart], materials: Sequence[Material], *, device: str = "cpu", **rest: Any
) -> DeviceScene:
    """The same scene on a device."""
    return DeviceScene(scene_of(parts, materials, **rest), device)


def camera_of(device_scene: DeviceScene, camera: Camera, size: tuple[int, int]) -> wp.array:
    """`camera` as kernels take it, for an image of `size` (width, height)."""
    data = camera_data(camera, device_scene.scene.placement, size[0] / size[1])
    return wp.array([data], dtype=CameraData, device="cpu")


def column(values: Any, dtype: Any, device: str = "cpu") -> wp.array:
    """A Warp array on a device."""
    return wp.array(np.ascontiguousarray(values), dtype=dtype, device=device)


def results(
    kernel: wp.Kernel, count: int, inputs: Sequence[Any], dtype: Any, width: int | None = None, device: str = "cpu"
) -> Doubles:
    """What `kernel` writes into its last argument, (count,) or (count · width,) of `dtype`, as float64."""
    out = wp.zeros(count * (width or 1), dtype=dtype, device=device)
    launch(kernel, count, [*inputs, out], wp.get_device(device))
    return np.asarray(out.numpy(), np.float64)


def rectangle_over(half_x: float, half_z: float, height: float) -> float:
    """Form factor from a point to a parallel rectangle centred over it (Siegel and Howell, configuration B-3)."""
    a, b = half_x / height, half_z / height
    ra, rb = np.hypot(1.0, a), np.hypot(1.0, b)
    return float(2.0 / np.pi * (a / ra * np.arctan(b / ra) + b / rb * np.arctan(a / rb)))


def square_of_vpls(count: int, height: float = 0.0, flux: float = 1.0, *, seed: int | None = None) -> Vpls:
    """About `count` VPLs of a mean `flux` over a square of area 0.36 that faces up, in a grid or strewn by a seed."""
    side = int(count**0.5)
    grid = (np.arange(side) + 0.5) / side * 0.6 - 0.3
    x, z = np.meshgrid(grid, grid)
    if seed is not None:
        x, z = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, side, side))
    vpls = allocate_vpls(side * side, wp.get_device("cpu"))
    vpls.position = column(np.stack([x.ravel(), np.full(side * side, height), z.ravel()], axis=1), wp.vec3)
    vpls.normal = column(np.tile([0.0, 1.0, 0.0], (side * side, 1)), wp.vec3)
    vpls.flux = column(flux * np.random.default_rng(0).uniform(0.5, 1.5, (side * side, 3)), wp.vec3)
    return vpls


def strewn_vpls(count: int, tilt: float, seed: int) -> Vpls:
    """VPLs on patches here and there, of normals that stray by about `tilt` from those of their patch."""
    rng = np.random.default_rng(seed)
    patches, patch = 40, rng.integers(0, 40, count)
    centre, axis = rng.uniform(-0.5, 0.5, (patches, 3)), rng.normal(size=(patches, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    offset = rng.normal(0.0, 0.05, (count, 3))
    offset -= (offset * axis[patch]).sum(axis=1, keepdims=True) * axis[patch]
    normal = axis[patch] + rng.normal(0.0, tilt, (count, 3))
    vpls = allocate_vpls(count, wp.get_device("cpu"))
    vpls.position = column(centre[patch] + offset, wp.vec3)
    vpls.normal = column(normal / np.linalg.norm(normal, axis=1, keepdims=True), wp.vec3)
    vpls.flux = column(rng.uniform(0.1, 3.0, (count, 3)), wp.vec3)
    return vpls


def slats(resident_size: tuple[int, int] = (64, 48), count: int = 24) -> tuple[DeviceScene, Camera, tuple[int, int]]:
    """A room lit from above with thin, close slats before its back wall: hard for clusters of shading points."""
    parts = box(0)
    parts.append(quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1))
    for k in range(count):
        x = -0.4 + 0.8 * k / count
        parts.append(quad((x, -0.4, -0.3), (0.02, 0.0, 0.02), (0.0, 0.8, 0.0), 0))
    device_scene = resident_of(parts, [grey(0.6), grey(0.0, 8.0)])
    return device_scene, look_at((0.0, 0.0, 0.48), (0.0, 0.0, -0.5), yfov_degrees=70.0), resident_size


def trace_light_paths(device_scene: DeviceScene, scene: SceneData, table: LightTable, paths: int, bounces: int,
                      seed: int, *, arriving: bool = False) -> Vpls:  # fmt: skip
    """The VPLs, or photons, of `paths` light paths of at most `bounces` hits, sorted; none when nothing is lit."""
    device = device_scene.device
    ends = PathEnds(paths, bounces, device, arriving=arriving)
    features = device_scene.generalised().features(lambertian=False)
    ends.trace(scene, table, wp.full(1, seed, dtype=int, device=device), features)
    count = int(ends.filled.numpy()[0])
    vpls = allocate_vpls(count, device)
    launch(gather_vpls_kernel, count, [ends.order, ends.raw, vpls], device)
    return vpls


def traced_vpls(device_scene: DeviceScene, scene: SceneData, wanted: int, bounces: int) -> Vpls:
    """About `wanted` VPLs of the scene's own lights."""
    table, features = build_light_table(device_scene), device_scene.generalised().features(lambertian=False)
    paths = paths_for(device_scene, scene, table, wanted, bounces, features)
    return trace_light_paths(device_scene, scene, table, paths, bounces, 0)
