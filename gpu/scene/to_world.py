"""Cameras and lights from a file's coordinates to the world's and to unit space."""

from dataclasses import replace

import numpy as np

from gpu.scene.computable import MOST
from gpu.scene.file_frame import FileFrame
from gpu.scene.floats import triple
from gpu.scene.types import Camera, Doubles, Light, LightKind, Placement


def camera_in_world(camera: Camera, frame: FileFrame) -> Camera:
    """A camera of the file in the world."""
    half_height = camera.half_height * (frame.metres_per_unit if camera.orthographic else 1.0)
    near = camera.near * frame.metres_per_unit
    return replace(camera, to_world=matrix_in_world(camera.to_world, frame), half_height=half_height, near=near)


def matrix_in_world(matrix: Doubles, frame: FileFrame) -> Doubles:
    """The matrix (4, 4) of a camera of the file in the world."""
    to_world = matrix.copy()
    to_world[:3, :3] = frame.turned(matrix[:3, :3].T).T
    to_world[:3, 3] = frame.to_world(matrix[:3, 3])
    return to_world


def light_in_unit_space(light: Light, frame: FileFrame, placement: Placement, said_metres: float) -> Light:
    """A light of the file in unit space. Distances shrink, so intensity by their square: irradiance stays the same.

    said_metres: the unit for which the light's intensity is meant, which a guess of the unit does not change.
    """
    light = placed_light(light, np.array(light.position), np.array(light.direction), frame, placement)
    if light.kind is LightKind.DIRECTIONAL:
        return light
    scale = intensity_scale(frame, placement, said_metres)
    return replace(light, intensity=triple(np.minimum(np.array(light.intensity) * scale, MOST)))


def intensity_scale(frame: FileFrame, placement: Placement, said_metres: float) -> float:
    """How many times its intensity in the file a point or spot light has in unit space."""
    return (placement.scale * frame.metres_per_unit / said_metres) ** 2


def placed_light(light: Light, position: Doubles, direction: Doubles, frame: FileFrame, placement: Placement) -> Light:
    """`light` in unit space at a position and in a direction of the file, (3,); a directional one has no place."""
    light = replace(light, direction=triple(frame.turned(direction)))
    if light.kind is LightKind.DIRECTIONAL:
        return light
    return replace(light, position=triple((frame.to_world(position) - placement.centre) * placement.scale))
