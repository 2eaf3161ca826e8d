import numpy as np

from gpu.scene.edits import SceneEdits, edited
from gpu.scene.load import load_scene
from gpu.scene.parts import lights_of
from tests.bench.edits import edits_of, inner_objects, mixed, with_bulb, with_motion


def test_the_scene_that_is_measured_has_a_bulb_and_an_object_that_goes_down() -> None:
    scene = with_motion(with_bulb(load_scene("cornell-box")))
    assert {"dim", "mix", "recolour", "move light", "material", "move object", "time"} == set(edits_of(scene))
    (one, low), *_ = inner_objects(scene)
    own = scene.vertex_object == scene.objects.index(one)
    rest, end = (edited(scene, SceneEdits(time=time)).vertices for time in (0.0, 4.0))
    assert np.allclose(rest, scene.vertices, atol=1e-6)
    assert np.array_equal(end[~own], scene.vertices[~own])
    moved = (end[own] - scene.vertices[own]) / scene.placement.scale
    assert np.allclose(moved, (0.0, 0.5 * (scene.bounds[0][1] - low[1]), 0.0), atol=1e-5)
    assert moved[0, 1] < 0.0


def test_a_mix_changes_all_lights() -> None:
    scene = with_bulb(load_scene("cornell-box"))
    assert len({edit.intensity for edit in mixed(scene, 0.7).lights.values()}) == 2
    assert set(mixed(scene, 0.7).lights) == {part.id for part in lights_of(scene)}
