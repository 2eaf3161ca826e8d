from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, resident_of

from gpu.core.device import RAY_REGISTERS, launch
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.specialisation import (
    cutouts_of,
    made_for,
    masks_of,
    ray_registers,
    specialisation,
    surface_specialisation,
)
from gpu.device_scene.surface import Surface
from gpu.scene.types import AlphaMode, Material, Texture, TextureSlot

NOTHING = SceneFeatures(**dict.fromkeys(vars(EVERYTHING), False) | {"constants": True})


@made_for("masks", "gloss")
def told_kernel(features: SceneFeatures, offset: int) -> wp.Kernel:
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def told_kernel(first: int, scene: SceneData, found: wp.array[int]) -> None:
        scene = specialise(scene)
        found[0] = scene.masked_count + offset
        found[1] = int(scene.glossy)
        found[2] = int(scene.ignore_alpha)
        found[3] = scene.pane_count

    return told_kernel


@made_for("sheen")
def shaped_kernel(features: SceneFeatures) -> wp.Kernel:
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def shaped_kernel(first: int, scene: SceneData, found: wp.array[int]) -> None:
        scene = specialise(scene)
        found[0] = int(scene.sheened)

    return shaped_kernel


def told(features: SceneFeatures) -> list[int]:
    scene = SceneData()
    scene.masked_count, scene.pane_count, scene.glossy = 5, 7, True
    found = wp.zeros(4, dtype=int, device="cpu")
    launch(told_kernel(features, 0), 1, [scene, found], wp.get_device("cpu"))
    return np.asarray(found.numpy()).tolist()


def test_kernels_take_what_they_are_made_for_to_be_absent_and_the_rest_as_it_is() -> None:
    assert told(EVERYTHING) == [5, 1, 0, 7]
    assert told(NOTHING) == [0, 0, 0, 7]
    assert told(replace(EVERYTHING, gloss=False)) == [5, 0, 0, 7]


def test_scenes_that_do_not_differ_in_it_have_one_kernel() -> None:
    assert told_kernel(EVERYTHING, 0) is told_kernel(replace(EVERYTHING, panes=False), 0)
    assert told_kernel(EVERYTHING, 0) is not told_kernel(replace(EVERYTHING, gloss=False), 0)
    assert told_kernel(EVERYTHING, 0) is not told_kernel(EVERYTHING, 1)


def test_without_constants_scenes_that_differ_in_what_only_these_tell_have_one_kernel() -> None:
    bare = replace(NOTHING, constants=False)
    assert told_kernel(bare, 0) is told_kernel(EVERYTHING, 0) is not told_kernel(NOTHING, 0)
    assert shaped_kernel(bare) is shaped_kernel(NOTHING) is not shaped_kernel(EVERYTHING)


@pytest.mark.parametrize("features", [EVERYTHING, NOTHING])
def test_surfaces_lose_what_scenes_have_not(features: SceneFeatures) -> None:
    known = surface_specialisation(features)

    @wp.kernel(module="unique")
    def known_kernel(first: int, surface: Surface, found: wp.array[float]) -> None:
        surface = known(surface)
        found[0] = surface.sheen[1] + surface.film

    surface, found = Surface(), wp.zeros(1, dtype=float, device="cpu")
    surface.sheen, surface.film = wp.vec3(0.0, 0.5, 0.0), 0.25
    launch(known_kernel, 1, [surface, found], wp.get_device("cpu"))
    assert found.numpy()[0] == (0.75 if features is EVERYTHING else 0.0)


@pytest.mark.parametrize(
    ("mode", "lambertian", "assumed", "masks", "alpha"),
    [
        (AlphaMode.OPAQUE, False, False, False, False),
        (AlphaMode.OPAQUE, False, True, True, True),
        (AlphaMode.MASK, False, False, True, True),
        (AlphaMode.MASK, True, False, True, False),
    ],
)
def test_masks_are_those_that_rays_look_for(mode: AlphaMode, lambertian: bool, assumed: bool, masks: bool,
                                            alpha: bool) -> None:  # fmt: skip
    device_scene = resident_of(box(), [grey(0.5) if mode is AlphaMode.OPAQUE else Material(alpha_mode=mode)])
    found = masks_of(device_scene.view(lambertian=lambertian, assume_alpha=assumed))
    assert (found.masks, found.alpha) == (masks, alpha)


@pytest.mark.parametrize(("texel", "cutouts"), [(255, False), (128, True)])
def test_gpus_are_told_where_no_texture_tells_how_much_there_is(texel: int, cutouts: bool) -> None:
    """Where rays look for no masks there is nothing to tell."""
    mask = Material(alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    texture = Texture("mask", np.full((1, 1, 4), texel, np.uint8), srgb=True)
    device_scene = resident_of(box(), [mask], textures=[texture])
    on_gpus = device_scene.as_on_gpus()
    assert cutouts_of(on_gpus.view(lambertian=False)).cutouts == cutouts
    assert masks_of(on_gpus.view(lambertian=False)).cutouts == cutouts
    for view in (on_gpus.view(lambertian=True), device_scene.view(lambertian=False)):
        assert cutouts_of(view).cutouts
    assert cutouts_of(on_gpus.generalised().view(lambertian=False)).cutouts


def test_rays_that_look_at_part_glass_have_no_more_registers_than_paths() -> None:
    assert ray_registers(EVERYTHING) == RAY_REGISTERS
    assert ray_registers(replace(EVERYTHING, part_glass=False)) is None
