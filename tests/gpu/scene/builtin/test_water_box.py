from math import pi

import numpy as np
import pytest
from builtin_scenes import face_normals, scene_of, world_corners

from gpu.scene.builtin.water_box import _DEPTH, _GAP, _WAVES
from gpu.scene.edits import SceneEdits, edited
from gpu.scene.types import Scene


def water_of(scene: Scene) -> np.ndarray:
    """The corners (triangle, 3, 3) of the water, in the world."""
    names = [material.name for material in scene.materials]
    return world_corners(scene)[scene.triangle_material == names.index("water")]


@pytest.mark.parametrize("time", [0.0, 1.3])
def test_the_water_is_closed_and_its_fronts_are_outside(time: float) -> None:
    scene = edited(scene_of("water-box"), SceneEdits(time=time))
    water = water_of(scene)
    area = np.linalg.norm(np.cross(water[:, 1] - water[:, 0], water[:, 2] - water[:, 0]), axis=1) / 2
    normals = face_normals(water)
    assert np.allclose(area @ normals, 0.0, atol=1e-7)
    volume = np.einsum("fc,fc->f", water.mean(axis=1), normals) @ area / 3.0
    assert volume == pytest.approx(4 * 0.266 * 0.274 * (_DEPTH - _GAP), rel=0.01)
    assert water[..., 1].min() == pytest.approx(_GAP, abs=1e-6)


def test_waves_travel_as_they_would_and_begin_anew() -> None:
    scene = scene_of("water-box")
    for wave in _WAVES:
        assert wave.frequency**2 == pytest.approx(9.81 * wave.number * np.tanh(wave.number * _DEPTH))
    time = 0.37
    for at in (time, 4.0 - time):
        points = water_of(edited(scene, SceneEdits(time=at))).reshape(-1, 3)
        x, y, z = points[points[:, 1] > _DEPTH / 2].T
        height = np.zeros_like(x)
        for wave in _WAVES:
            way = np.cos(np.radians(wave.degrees)) * x + np.sin(np.radians(wave.degrees)) * z
            height += wave.height * np.cos(wave.number * way - 2.0 * pi * wave.periods * at / 4.0)
        assert np.abs(y - _DEPTH - height).max() < 1e-4
    assert np.allclose(water_of(edited(scene, SceneEdits(time=4.0))), water_of(scene), atol=1e-6)


def test_its_normals_are_those_of_its_surface() -> None:
    scene = edited(scene_of("water-box"), SceneEdits(time=0.9))
    names = [material.name for material in scene.materials]
    triangles = scene.triangles[scene.triangle_material == names.index("water")]
    faces = face_normals(water_of(scene))
    given = scene.normals[triangles].mean(axis=1)
    given /= np.linalg.norm(given, axis=1)[:, None]
    assert np.einsum("fc,fc->f", faces, given).min() > 0.995
