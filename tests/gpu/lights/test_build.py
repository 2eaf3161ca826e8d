from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from emitters import POINT, lamp_room, share_kernel
from scenes import box, grey, quad, resident_of, results

from gpu.core.device import alike
from gpu.lights.build import build_light_table, emitters_after, emitters_of
from gpu.lights.light_table import LightTable
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.types import Material, Sky, Texture, TextureSlot


def test_punctual_lights_are_visited_when_few_and_sampled_when_many() -> None:
    few = build_light_table(lamp_room(lights=[POINT] * 8))
    assert (few.enumerated_count, few.sampled.count, few.count) == (8, 2, 2 + 8)
    many = build_light_table(lamp_room(lights=[POINT] * 9))
    assert (many.enumerated_count, many.sampled.count) == (0, 2 + 9)


@pytest.mark.parametrize(
    ("edits", "same"),
    [
        ({"lights": {"point": LightEdit(position=(0.0, 0.2, 0.1))}}, True),
        ({"lights": {"point": LightEdit(intensity=0.5)}}, True),
        ({"lights": {"point": LightEdit(on=False)}}, True),
        ({"lights": {"default": LightEdit(on=False)}}, False),
        ({"lights": {"sky": LightEdit(intensity=0.5)}}, False),
        ({"materials": {"default": MaterialEdit(emission=(1.0, 0.0, 0.0))}}, False),
        ({"materials": {"default": MaterialEdit(color=(1.0, 0.0, 0.0), roughness=0.5, metallic=0.2)}}, True),
        ({"objects": {"block": ObjectEdit(offset=(0.0, 0.0, 0.1))}}, True),
        ({"objects": {"block": ObjectEdit(visible=False)}}, False),
        ({"objects": {"lamp": ObjectEdit(scale=0.5)}}, False),
    ],
)
def test_powers_of_extended_emitters_are_found_again_where_an_edit_changes_one(
    edits: dict[str, Any], same: bool
) -> None:
    """The table is as it would be anew."""
    block = replace(quad([-0.2, -0.2, 0], [0.1, 0, 0], [0, 0.1, 0]), name="block")
    lamp = replace(quad([-0.1, 0.45, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 1), name="lamp")
    materials, sky = [grey(0.5), grey(0.0, emission=3.0)], Sky((0.1, 0.1, 0.1))
    base = resident_of([*box(), block, lamp], materials, lights=[POINT], sky=sky)
    emitters, state = emitters_of(base), base.edited(edited(base.scene, SceneEdits(**edits)))
    found, anew = emitters_after(emitters, base, state).table, build_light_table(state)
    assert (found.areas is emitters.table.areas) == same
    assert alike(LightTable, found, anew)
    for name in ("faces", "areas", "lights", "radius"):
        assert np.array_equal(getattr(found, name).numpy(), getattr(anew, name).numpy())
    for name in ("all_emitters", "sampled"):
        assert np.array_equal(getattr(found, name).cumulative.numpy(), getattr(anew, name).cumulative.numpy())


def test_glass_that_becomes_rough_may_change_the_numbers_of_faces_that_emit() -> None:
    pane, lamp = (
        quad((-0.2, -0.2, 0.0), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0), 1),
        quad((0, 0.4, 0), (0.1, 0, 0), (0, 0, 0.1), 2),
    )
    glass = replace(grey(1.0), name="glass", transmission=1.0, roughness=0.0)
    base = resident_of([*box(), pane, lamp], [grey(0.5), glass, replace(grey(0.0, emission=3.0), name="lamp")])
    state = base.edited(edited(base.scene, SceneEdits(materials={"glass": MaterialEdit(roughness=0.5)})))
    found = emitters_after(emitters_of(base), base, state).table
    assert np.array_equal(found.faces.numpy(), build_light_table(state).faces.numpy())
    assert not np.array_equal(found.faces.numpy(), build_light_table(base).faces.numpy())


def test_nothing_emits() -> None:
    dark = resident_of([*box()], [grey(0.5)], lights=[POINT])
    dark = dark.edited(replace(dark.scene, lights=()))
    table = build_light_table(dark)
    assert (table.count, table.all_emitters.count, table.sampled.count) == (0, 0, 0)


def test_lights_that_are_all_off_are_chosen_alike() -> None:
    """So that nothing else is to be made when one goes on."""
    off = replace(POINT, intensity=(0.0, 0.0, 0.0))
    table = build_light_table(resident_of([*box()], [grey(0.5)], lights=[off], sky=Sky((0.0, 0.0, 0.0))))
    assert table.count == 2
    assert results(share_kernel, 2, [table.all_emitters], float).tolist() == pytest.approx([0.5, 0.5])


def test_unlit_materials_are_no_lights() -> None:
    device_scene = resident_of(box(), [Material(emission=(1.0, 1.0, 1.0), unlit=True)], lights=[POINT])
    assert build_light_table(device_scene).triangle_count == 0


@pytest.mark.parametrize("samples", [None, 5])
def test_a_triangles_power_is_the_mean_over_a_lattice_of_its_points(samples: int | None) -> None:
    columns = np.random.default_rng(2).integers(0, 256, 64).astype(np.uint8)
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:, :, :3] = columns[None, :, None]
    lamp, plain = Material(emission=(1.0, 1.0, 1.0), emission_slot=TextureSlot(0)), grey(0.0, emission=1.0)
    parts = [quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1]), quad([-0.5, 0.5, -0.5], [1, 0, 0], [0, 0, 1], 1)]
    device_scene = resident_of(parts, [lamp, plain], textures=[Texture("bars", pixels, srgb=False, nearest=True)])
    options = {} if samples is None else {"power_samples": samples}
    chance = results(share_kernel, 4, [emitters_of(device_scene, **options).table.all_emitters], float)
    count = samples or 16
    x, y = (np.arange(count) + 0.5) / count, np.arange(count) * 0.618034 % 1.0
    u, v = 1.0 - np.sqrt(x), y * np.sqrt(x)
    for triangle, across in enumerate((1.0 - u, v)):  # of UVs (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1)
        mean = columns[(across * 64).astype(int)].mean() / 255.0
        assert chance[triangle] / chance[2] == pytest.approx(mean, rel=1e-3)


def test_a_dark_texel_does_not_end_a_particle_unchosen() -> None:
    pixels = np.zeros((64, 64, 4), np.uint8)
    pixels[3, 60] = 255  # one bright texel that the estimate of power misses
    lamp = Material(emission=(2.0, 2.0, 2.0), emission_slot=TextureSlot(0))
    device_scene = resident_of([quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1])], [lamp],
                           textures=[Texture("spark", pixels, srgb=True, nearest=True)])  # fmt: skip
    table = build_light_table(device_scene)
    assert table.count == 2
    assert (results(share_kernel, 2, [table.all_emitters], float) > 0.1).all()
