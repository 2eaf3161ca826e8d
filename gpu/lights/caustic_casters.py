"""Surfaces that cast caustics, chosen by their area: mirrors and clear glass, and those with narrow lobes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.device_scene.features import casts_by_lobe, is_specular
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import power_cdf
from gpu.lights.light_table import PowerCdf
from gpu.scene.types import Ints, Material


@dataclass(frozen=True)
class CausticShares:
    """How many of the light paths go to lobes: in proportion to their area in unit space, within limits, since what is
    small or faint sends little light. of_area [1/unit area].
    """

    of_area: float = 4.0
    least: float = 1.0 / 16.0
    most: float = 0.5


SHARES = CausticShares()


@wp.struct
class CausticCasters:
    """Triangles that light may meet as a mirror or clear glass, or those with `lobes`. share: of all light paths;
    faces, areas [unit area] (caster,); choice: among them, by area.
    """

    lobes: bool
    share: float
    faces: wp.array[int]
    areas: wp.array[float]
    choice: PowerCdf


def faces_of(device_scene: DeviceScene, casts: Callable[[Material], bool]) -> Ints:
    """The device's triangles whose material `casts` caustics somewhere, (triangle,)."""
    by_material = zip(device_scene.scene.materials, device_scene.faces_by_material, strict=True)
    faces = [faces for material, faces in by_material if casts(material)]
    return np.sort(np.concatenate(faces)) if faces else np.zeros(0, np.int32)


def casters_of(device_scene: DeviceScene, faces: Ints, *, lobes: bool) -> CausticCasters:
    """These `faces` of a scene as it is, with the `share` that lobes have by their area."""
    scene, device = device_scene.scene, device_scene.device
    corners = scene.vertices[scene.triangles[device_scene.triangle_order[faces]]].astype(np.float64)
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    casters = CausticCasters()
    casters.lobes = lobes
    casters.share = float(np.clip(SHARES.of_area * areas.sum(), SHARES.least, SHARES.most))
    casters.faces = wp.array(faces, dtype=wp.int32, device=device)
    casters.areas = wp.array(areas, dtype=wp.float32, device=device)
    casters.choice = power_cdf(areas, device)
    return casters


def caustic_casters(device_scene: DeviceScene) -> list[CausticCasters]:
    """What has lobes in a scene as it is, and its mirrors and clear glass, which get the rest of the light paths, as
    far as there are any.
    """
    kinds = [(faces_of(device_scene, casts_by_lobe), True), (faces_of(device_scene, is_specular), False)]
    casters = [casters_of(device_scene, faces, lobes=lobes) for faces, lobes in kinds if len(faces)]
    if casters and not casters[-1].lobes:
        casters[-1].share = 1.0 - sum(kind.share for kind in casters[:-1])
    return casters
