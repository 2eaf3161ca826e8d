"""Surfaces that cast caustics: mirrors and clear glass, chosen by their area."""

import numpy as np
import warp as wp

from gpu.device_scene.features import is_specular
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import power_cdf
from gpu.lights.light_table import PowerCdf
from gpu.scene.types import Ints


@wp.struct
class CausticCasters:
    """Triangles that light may meet as a mirror or clear glass. faces, areas [unit area] (caster,); choice: among them,
    by area; its count is 0 where there is none.
    """

    faces: wp.array[int]
    areas: wp.array[float]
    choice: PowerCdf


def specular_faces(device_scene: DeviceScene) -> Ints:
    """The device's triangles whose material is of a mirror or clear glass somewhere, (triangle,)."""
    by_material = zip(device_scene.scene.materials, device_scene.faces_by_material, strict=True)
    faces = [faces for material, faces in by_material if is_specular(material)]
    return np.sort(np.concatenate(faces)) if faces else np.zeros(0, np.int32)


def caustic_casters(device_scene: DeviceScene) -> CausticCasters:
    """Those of a scene as it is."""
    scene, device, faces = device_scene.scene, device_scene.device, specular_faces(device_scene)
    corners = scene.vertices[scene.triangles[device_scene.triangle_order[faces]]].astype(np.float64)
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    casters = CausticCasters()
    casters.faces = wp.array(faces, dtype=wp.int32, device=device)
    casters.areas = wp.array(areas, dtype=wp.float32, device=device)
    casters.choice = power_cdf(areas, device)
    return casters
