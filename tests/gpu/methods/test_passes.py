from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from pictures import CAMERA, CURTAIN, coated_room, curtained_room, picture, sunlit_room
from pictures import SIZE as PICTURE
from scenes import RARE, box, column, grey, quad, resident_of
from stage_order import repeated_launches

from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import AlphaMode, Material
from gpu.settings import Component, Method, RenderSettings

SIZE = (12, 8)
PANE = Material(transmission=1.0, roughness=0.0)
VEIL = Material(base_color=(0.8, 0.8, 0.8, 0.4), alpha_mode=AlphaMode.BLEND)


def test_indirect_light_is_added_to_what_is_there() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    view.set_camera(look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0)))
    view.find_shading_points()
    direct, irradiance = np.random.default_rng(0).uniform(size=(2, 96, 3)).astype(np.float32)
    view.radiance.assign(column(direct, wp.vec3))
    view.indirect.irradiance.assign(column(irradiance, wp.vec3))
    view.shading_points.reflect(view.gbuffer, view.indirect.irradiance, view.brightness.value, view.radiance)
    assert np.allclose(view.radiance.numpy(), direct + 0.5 / np.pi * irradiance)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL, Method.PHOTON_GATHER, Method.RSM_DISKS])
def test_chains_are_drawn_by_the_seed_of_the_settings(method: Method) -> None:
    settings = RenderSettings(method=method, seed=7, vpls=64, vpl_clusters=8, sp_clusters=8, photons=1000)
    renderer = Renderer(resident_of(box(), [grey(0.5, emission=1.0)]), SIZE, settings)
    assert renderer._method._frame.chain_samples.seed == 7  # type: ignore[attr-defined]


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL, Method.RSM_DISKS, Method.PHOTON_GATHER])
@pytest.mark.parametrize("transmission", [0.3, 0.6])
def test_a_room_is_lit_through_a_pane_of_glass_in_part(method: Method, transmission: float) -> None:
    room, camera = sunlit_room(replace(PANE, base_color=(0.9, 0.9, 0.9, 1.0), transmission=transmission))
    bounces = 1 if method is Method.RSM_DISKS else 4
    settings = {"bounces": bounces, "vpls": 8000, "photons": 20_000, "samples": 8}
    seen = picture(room, camera, **settings, method=method)
    paths = picture(room, camera, **{**settings, "samples": 512}, method=Method.PATH)
    assert seen.mean() == pytest.approx(paths.mean(), rel=0.05)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
@pytest.mark.parametrize("colour", [(0.9, 0.9, 0.9), (0.9, 0.4, 0.2)])
def test_what_a_whole_pane_takes_of_indirect_light_is_gone(method: Method, colour: tuple[float, float, float]) -> None:
    """A lamp is behind it, and all that is seen is seen through it, or lit so."""
    room = curtained_room(replace(PANE, base_color=(*colour, 1.0), transmission=1.0))
    seen = picture(room, method=method, vpls=8000, samples=8)
    paths = picture(room, method=Method.PATH, samples=512)
    assert seen.mean(axis=(0, 1)) == pytest.approx(paths.mean(axis=(0, 1)), rel=0.03 if len(set(colour)) == 1 else 0.08)


@pytest.mark.parametrize("transmission", [0.3, 0.6])
def test_photons_tell_what_is_behind_a_pane_and_on_it(transmission: float) -> None:
    """Both are seen in a single frame, each by its share."""
    room = curtained_room(replace(PANE, transmission=transmission))
    seen = picture(room, method=Method.PHOTON_GATHER, photons=40_000, samples=8)
    paths = picture(room, method=Method.PATH, samples=512)
    assert seen.mean() == pytest.approx(paths.mean(), rel=0.08)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
@pytest.mark.parametrize("material", [*RARE, PANE, VEIL, CURTAIN])
def test_direct_and_indirect_light_of_glass_coats_and_veils_add_up(method: Method, material: Material) -> None:
    """A lamp before and one behind a plate, of which frosted glass shows both, and a coat what it reflects. Of a veil
    direct light is that of its likelier branch.
    """
    lamps = (quad((-0.2, 0.49, z), (0.4, 0.0, 0.0), (0.0, 0.0, 0.2), 1) for z in (-0.4, 0.1))
    plate = quad((-0.49, -0.49, -0.1), (0.98, 0.0, 0.0), (0.0, 0.98, 0.0), 2)
    room = resident_of([*box(), *lamps, plate], [grey(0.4), grey(0.0, emission=5.0), material, *RARE]).generalised()
    full, direct, indirect = (picture(room, method=method, component=component, samples=8) for component in Component)
    seen = picture(room, method=Method.PATH, component=Component.DIRECT, samples=256)
    if material is VEIL:
        whole = picture(room, method=Method.PATH, samples=256)
        assert full.mean() == pytest.approx(whole.mean(), rel=0.05)
    else:
        assert direct.mean() == pytest.approx(seen.mean(), rel=0.05)
    assert (direct + indirect).mean() == pytest.approx(full.mean(), rel=0.01)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.PHOTON_GATHER])
def test_at_rest_a_coat_shows_a_lamp_without_fireflies(method: Method) -> None:
    """It reflects 4 % of the lamp's light: a chain in 50 that ended in the lamp would bring fifty times as much."""
    room, counts = coated_room(), {"vpls": 2000, "sp_clusters": 200, "photons": 8000, "gather_rays": 64}
    renderer = Renderer(room, PICTURE, RenderSettings(method=method, **counts))
    mean = Accumulation(PICTURE[0] * PICTURE[1], room.device)
    *_, rests = (renderer.render(CAMERA, mean).radiance()[28:] for _ in range(16))
    paths = picture(room, method=Method.PATH, samples=256)[28:]
    assert rests.mean() == pytest.approx(paths.mean(), rel=0.08)
    assert rests.max() < 1.5 * np.percentile(paths, 99)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL, Method.PHOTON_GATHER, Method.RSM_DISKS])
def test_what_repeats_launches_the_same_in_frames_of_a_walk_and_at_rest(
    method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A GPU would replay what the first of them has launched."""
    room, counts = coated_room(), {"vpls": 500, "vpl_clusters": 16, "sp_clusters": 20, "photons": 1000}
    renderer = Renderer(room, PICTURE, RenderSettings(method=method, gather_rays=16, **counts))
    mean, launched = Accumulation(PICTURE[0] * PICTURE[1], room.device), repeated_launches(monkeypatch)
    for _ in range(2):
        renderer.render(CAMERA, walks=True)
    for _ in range(6):
        renderer.render(CAMERA, mean)
    assert {len(times) for times in launched.values()} > {1}
    for stage, times in launched.items():
        assert all(other == times[0] for other in times), stage
