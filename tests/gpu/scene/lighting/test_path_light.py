from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of

from gpu.scene.edits import LightEdit, MaterialEdit, SceneEdits, edited
from gpu.scene.lighting.path_light import path_light, path_light_shares
from gpu.scene.types import Environment, Light, LightKind, Material, Scene, Sky

LAMP = Material("lamp", emission=(4.0, 2.0, 0.0), specular=0.0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    lamp = quad((-0.2, 0.4, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    lights = [Light("bulb", LightKind.POINT, (0.2, 0.2, 0.2)), Light("glow", LightKind.POINT, (0.001, 0.001, 0.001))]
    return scene_of([*box(), lamp], [grey(0.5), LAMP], lights=lights, sky=Sky((0.02, 0.02, 0.04)))


def with_lights(scene: Scene, **edits: LightEdit) -> Scene:
    return edited(scene, SceneEdits(lights=edits))


def shone(scene: Scene) -> list[tuple[float, ...]]:
    """The light of each part of a scene by what it is drawn as and what it is of that."""
    drawn = path_light(scene)
    assert drawn.sky is not None
    sky = drawn.sky.tint if isinstance(drawn.sky, Environment) else drawn.sky.radiance
    colors = [*(one.emission for one in drawn.materials), sky, *(one.intensity for one in drawn.lights)]
    return [tuple(color) for color in np.array(colors) * path_light_shares(scene)]


def test_paths_are_those_of_the_file_whatever_lights_are_dimmed_to(scene: Scene) -> None:
    for edits in (
        {"bulb": LightEdit(on=False), "sky": LightEdit(intensity=0.3)},
        {"lamp": LightEdit(color=(1.0, 0.2, 1.0), intensity=2.0)},
        {"lamp": LightEdit(on=False), "bulb": LightEdit(intensity=0.5)},
    ):
        found = with_lights(scene, **edits)
        drawn = path_light(found)
        assert np.allclose([one.emission for one in drawn.materials], [one.emission for one in scene.materials])
        assert (drawn.lights, drawn.sky) == (scene.lights, scene.sky)
        assert found.sky is not None
        whole = [*(one.emission for one in found.materials), found.sky.radiance, *(it.intensity for it in found.lights)]
        assert np.allclose(shone(found), whole, rtol=1e-6, atol=0.0)


def test_a_scene_without_edits_is_drawn_as_it_is(scene: Scene) -> None:
    assert path_light(scene) is scene
    assert (path_light_shares(scene) == 1.0).all()


def test_a_channel_that_the_file_has_not_can_be_lit(scene: Scene) -> None:
    found = with_lights(scene, lamp=LightEdit(color=(0.0, 0.0, 1.0)))
    assert path_light(found).materials[1].emission[2] > 0.0
    assert shone(found)[1] == pytest.approx((0.0, 0.0, 4.0))


def test_one_small_light_that_shines_alone_has_paths_of_its_own(scene: Scene) -> None:
    """In steps, so that few of its edits need other paths, and they depend on no edit before."""
    off = LightEdit(on=False)
    alone = {"lamp": off, "bulb": off, "sky": off}
    drawn = [
        path_light(with_lights(scene, **alone, glow=LightEdit(intensity=factor))) for factor in (0.6, 1.0, 1.9, 8.0)
    ]
    assert [one.lights[1].intensity[0] for one in drawn] == pytest.approx([0.001, 0.001, 0.001, 0.016])
    assert all(one.lights[0].intensity == (0.0,) * 3 for one in drawn)


def test_paths_of_a_surface_that_is_made_to_emit_are_drawn_in_steps(scene: Scene) -> None:
    for radiance, drawn in ((3.0, 4.0), (7.0, 4.0), (0.3, 0.25)):
        edits = SceneEdits(materials={"default": MaterialEdit(emission=(radiance,) * 3)})
        found = edited(scene, edits)
        assert path_light(found).materials[0].emission == pytest.approx((drawn,) * 3)
        assert shone(found)[0] == pytest.approx((radiance,) * 3)


def test_a_picture_around_the_scene_is_drawn_as_its_file_says(scene: Scene) -> None:
    hall = replace(scene, sky=Environment("hall.hdr", np.full((4, 8, 3), 2.0, np.float32)))
    found = with_lights(hall, sky=LightEdit(intensity=0.5))
    assert isinstance(found.sky, Environment)
    drawn = path_light(found).sky
    assert isinstance(drawn, Environment)
    assert drawn.tint == (1.0, 1.0, 1.0)
    assert path_light_shares(found)[2].tolist() == [0.5] * 3


def test_areas_of_materials_are_those_of_their_triangles(scene: Scene) -> None:
    assert scene.material_areas == pytest.approx([6.0, 0.16])
    assert scene.light_areas.tolist() == [0.0, scene.material_areas[1]]


def test_a_light_is_dimmed_without_a_look_at_what_does_not_shine(scene: Scene) -> None:
    fresh = replace(scene)
    assert with_lights(fresh, lamp=LightEdit(intensity=0.5)).materials[1].path_color is not None
    assert {"light_areas"} == {"light_areas", "material_areas"} & fresh.__dict__.keys()
