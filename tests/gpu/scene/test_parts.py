from dataclasses import replace

import numpy as np
from scenes import box, grey, scene_of

from gpu.scene.parts import MOST_ID, LightForm, lights_of, material_ids, unique_ids
from gpu.scene.types import Environment, Light, LightKind, Material, Sky


def test_ids_are_names_and_differ() -> None:
    assert unique_ids(["lamp", "", "lamp", "lamp (2)", " ", "lamp"], "light") == (
        "lamp", "light", "lamp (2)", "lamp (2) (2)", "light (2)", "lamp (3)",
    )  # fmt: skip
    long = unique_ids(["x" * 1000] * 3, "material")
    assert len(set(long)) == 3
    assert max(len(one) for one in long) <= MOST_ID + 4


def test_many_things_of_one_name_are_soon_told_apart() -> None:
    assert len(set(unique_ids(["same"] * 50_000, "material"))) == 50_000


def test_all_that_shines_is_a_light_and_has_the_colour_of_the_file() -> None:
    lights = [
        Light("bulb", LightKind.POINT, (2.0, 1.0, 0.5)),
        Light("", LightKind.SPOT, (0.0, 0.0, 0.0)),
        Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0)),
    ]
    materials = [grey(0.5), Material("lamp", emission=(4.0, 2.0, 0.0)), Material("sign", emission=(1,) * 3, unlit=True)]
    scene = scene_of(box(), materials, lights=lights, sky=Sky((0.1, 0.2, 0.4)))
    found = lights_of(scene)
    assert [(part.id, part.form, part.index) for part in found] == [
        ("bulb", LightForm.POINT, 0),
        ("spot", LightForm.SPOT, 1),
        ("sun", LightForm.DIRECTIONAL, 2),
        ("lamp", LightForm.SURFACE, 1),
        ("sky", LightForm.SKY, 0),
    ]
    assert [part.color for part in found] == [(1.0, 0.5, 0.25), (1.0,) * 3, (1.0,) * 3, (1.0, 0.5, 0.0),
                                              (0.25, 0.5, 1.0)]  # fmt: skip
    assert material_ids(scene) == ("default", "lamp", "sign")
    assert not any(part.added for part in found)
    picture = Environment("hall.hdr", np.full((1, 2, 3), 7.0, np.float32))
    assert lights_of(replace(scene, sky=picture))[-1].color == (1.0, 1.0, 1.0)


def test_a_sun_and_a_sky_that_a_scene_has_not_come_last_and_take_no_name() -> None:
    lamp = Material("sun", emission=(4.0, 4.0, 4.0))
    found = lights_of(scene_of(box(), [grey(0.5), lamp], lights=[Light("sky", LightKind.POINT, (1.0, 1.0, 1.0))]))
    assert [(part.id, part.form, part.index, part.added) for part in found] == [
        ("sky", LightForm.POINT, 0, False),
        ("sun", LightForm.SURFACE, 1, False),
        ("sun (2)", LightForm.DIRECTIONAL, 1, True),
        ("sky (2)", LightForm.SKY, 0, True),
    ]
