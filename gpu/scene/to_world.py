"""Cameras and lights from a file's coordinates to the world's and to unit space."""

from dataclasses import replace

import numpy as np

from gpu.scene.file_frame import FileFrame
from gpu.scene.types import Camera, Doubles, Light, LightKind, Placement


def camera_in_world(camera: Camera, frame: FileFrame) -> Camera:
    """A camera of the file in the world."""
    to_world = camera.to_world.copy()
    to_world[:3, :3] = frame.turned(camera.to_world[:3, :3].T).T
    to_world[:3, 3] = frame.to_world(camera.to_world[:3, 3])
    half_height = camera.half_height * (frame.metres_per_unit if camera.orthographic else 1.0)
    return replace(camera, to_world=to_world, half_height=half_height, near=camera.near * frame.metres_per_unit)


def light_in_unit_space(light: Light, frame: FileFrame, placement: Placement, said_metres: float) -> Light:
    """A light of the file in unit space. Distances shrink, so intensity by their square: irradiance stays the same.

    said_metres: the unit for which the light's intensity is meant, which a guess of the unit does not change.
    """
    light = replace(light, direction=as_vector(frame.turned(np.array(light.direction))))
    if light.kind is LightKind.DIRECTIONAL:
        return light
    position = (frame.to_world(np.array(light.position)) - placement.centre) * placement.scale
    shrunk = placement.scale * frame.metres_per_unit / said_metres
    return replace(light, position=as_vector(position), intensity=as_vector(np.array(light.intensity) * shrunk**2))


def as_vector(values: Doubles) -> tuple[float, float, float]:
    """Three numbers of an array as plain floats."""
    return (float(values[0]), float(values[1]), float(values[2]))
