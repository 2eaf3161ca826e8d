"""A furnished box, and pictures of it, for tests of methods."""

from dataclasses import replace

import numpy as np
from scenes import RARE, box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Camera, Floats, Light, LightKind, Material
from gpu.settings import RenderSettings

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
QUALITY = {"sp_clusters": 200, "vpls": 2000, "vpl_clusters": 100}


def lamp_room(device: str = "cpu") -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)], device=device)


def sconce_room() -> DeviceScene:
    """The same box with a lamp that shines both ways, close to the wall to the left of CAMERA."""
    lamp = quad((-0.485, 0.05, -0.15), (0.0, 0.1, 0.0), (0.0, 0.0, 0.06), 1)
    block = quad((-0.1, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.6), replace(grey(0.0, 40.0), double_sided=True), grey(0.4)])


def coated_room() -> DeviceScene:
    """A box with a lamp below its ceiling and a floor that is black but for its clear coat."""
    lamp = quad((-0.2, 0.49, -0.45), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    floor = quad((-0.49, -0.4, -0.49), (0.0, 0.0, 0.98), (0.98, 0.0, 0.0), 2)
    coated = replace(grey(0.0), clearcoat=1.0)
    return resident_of([*box(), lamp, floor], [grey(0.7), grey(0.0, 5.0), coated, *RARE]).generalised()


def mirror_room() -> DeviceScene:
    """The same box without its block, with a mirror before the wall that CAMERA looks at."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    mirror = quad((-0.3, -0.3, -0.45), (0.6, 0.0, 0.0), (0.0, 0.5, 0.0), 2)
    polished = Material(base_color=(0.9, 0.9, 0.9, 1.0), metallic=1.0, roughness=0.0)
    return resident_of([*box(), lamp, mirror], [grey(0.7), grey(0.0, 5.0), polished]).generalised()


CURTAIN = Material(
    base_color=(0.8, 0.8, 0.8, 1.0),
    diffuse_transmission=0.5,
    diffuse_transmission_color=(0.9, 0.8, 0.6),
    double_sided=True,
)


def curtained_room(curtain: Material = CURTAIN) -> DeviceScene:
    """The same box without its block, parted by a curtain; CAMERA is in one part, the lamp in the other."""
    lamp = quad((-0.15, 0.49, -0.4), (0.3, 0.0, 0.0), (0.0, 0.0, 0.2), 1)
    sheet = quad((-0.499, -0.499, -0.1), (0.998, 0.0, 0.0), (0.0, 0.998, 0.0), 2)
    return resident_of([*box(), lamp, sheet], [grey(0.7), grey(0.0, 5.0), curtain])


def sunlit_room(pane: Material) -> tuple[DeviceScene, Camera]:
    """The same box without lamp and block, lit by the sun through a window in one wall, and a view of that."""
    walls = [part for part in box() if not (part.positions[:, 0] == 0.5).all()]
    around = (-0.5, -0.5, 1.0, 0.4), (-0.5, 0.3, 1.0, 0.2), (-0.5, -0.1, 0.2, 0.4), (0.3, -0.1, 0.2, 0.4)
    walls += [quad((0.5, y, z), (0.0, 0.0, depth), (0.0, height, 0.0)) for z, y, depth, height in around]
    window = quad((0.5, -0.1, -0.3), (0.0, 0.0, 0.6), (0.0, 0.4, 0.0), 1)
    slope = np.array([-0.7, -0.6, -0.1])
    sun = Light("sun", LightKind.DIRECTIONAL, (10.0, 10.0, 10.0), direction=tuple(slope / np.linalg.norm(slope)))
    camera = look_at((-0.42, 0.1, 0.42), (0.4, -0.15, -0.2), yfov_degrees=75.0)
    return resident_of([*walls, window], [grey(0.7), pane], lights=[sun]), camera


def long_room() -> tuple[DeviceScene, Camera]:
    """A closed corridor of shiny walls with a small lamp at one end, and a view of the other."""
    corridor = [
        MeshPart(part.positions * (1.0, 0.5, 0.5), part.triangles, uvs=part.uvs, material=part.material)
        for part in box()
    ]
    lamp = quad((-0.44, 0.2, -0.04), (0.08, 0.0, 0.0), (0.0, 0.0, 0.08), 1)
    shiny = Material(base_color=(0.8, 0.8, 0.8, 1.0), roughness=0.5)
    camera = look_at((-0.3, 0.0, 0.0), (0.5, 0.0, 0.0), yfov_degrees=70.0)
    return resident_of([*corridor, lamp], [shiny, grey(0.0, 20.0)]).generalised(), camera


def picture(device_scene: DeviceScene, camera: Camera = CAMERA, **settings: object) -> Floats:
    """Linear radiance of a frame."""
    return Renderer(device_scene, SIZE, RenderSettings(**{**QUALITY, **settings})).render(camera).radiance()


def relative_error(x: Floats, r: Floats) -> float:
    return float(np.mean((x - r) ** 2 / (r**2 + 0.01 * r.mean() ** 2)))
