from dataclasses import replace

import numpy as np
import pytest
from pictures import CAMERA, SIZE, coated_room, lamp_room, picture, relative_error, sconce_room
from scenes import RARE, box, grey, quad, resident_of
from stage_order import noted_stages

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Floats, Material
from gpu.settings import EVERY_SKIP, Component, Method, RenderSettings
from tests.bench.figures import flicker

INDIRECT = {"component": Component.INDIRECT, "lambertian": True}
COUNTS = {"photons": 16_000, "gather_rays": 64}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


@pytest.fixture(scope="module")
def paths(room: DeviceScene) -> Floats:
    return picture(room, method=Method.PATH, samples=256, **INDIRECT)


@pytest.mark.parametrize("cut_nodes", [0, 4096])
def test_it_agrees_with_path_tracing(room: DeviceScene, paths: Floats, cut_nodes: int) -> None:
    gathered = picture(room, method=Method.PHOTON_GATHER, cut_nodes=cut_nodes, **INDIRECT, **COUNTS)
    assert gathered.mean() == pytest.approx(paths.mean(), rel=0.03)
    assert relative_error(gathered, paths) < 0.005


@pytest.mark.parametrize("cut_nodes", [0, 4096])
def test_a_lamp_close_to_a_wall_leaves_no_bright_spots_elsewhere(cut_nodes: int) -> None:
    """Few of a centre's rays meet the wall behind it, which is 200 times as bright as the mean of the room."""
    room = sconce_room()
    gathered = picture(room, method=Method.PHOTON_GATHER, cut_nodes=cut_nodes, **INDIRECT, **COUNTS)
    paths = picture(room, method=Method.PATH, samples=256, **INDIRECT)
    assert gathered.mean() == pytest.approx(paths.mean(), rel=0.05)
    far = gathered[:22, 22:, 0]
    assert far.max() < 1.65 * np.median(far)


def test_a_glossy_floor_shows_what_its_lobes_reflect() -> None:
    """A room with a dark block in polished metal, in parts of the floor; as even light they would be off by 0.009."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.1, -0.3, -0.3), (0.35, 0.0, 0.0), (0.0, 0.4, 0.1), 2)
    floor = quad((-0.5, -0.45, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 3)
    metal = Material(base_color=(0.8, 0.8, 0.8, 1.0), metallic=1.0, roughness=0.35)
    room = resident_of([*box(), lamp, block, floor], [grey(0.7), grey(0.0, 5.0), grey(0.2), metal]).generalised()
    choice = {"component": Component.INDIRECT, "sp_clusters": 300}
    gathers = {"method": Method.PHOTON_GATHER, "photons": 16_000, "gather_rays": 128}
    seen, paths = (
        picture(room, **choice, **method)[22:].reshape(2, 7, 6, 8, 3).mean(axis=(1, 3))
        for method in (gathers, {"method": Method.PATH, "samples": 128})
    )
    assert seen.mean() == pytest.approx(paths.mean(), rel=0.05)
    assert relative_error(seen, paths) < 0.005


@pytest.mark.parametrize("material", RARE)
def test_glass_is_matt_and_a_coat_takes_no_light_away(material: Material) -> None:
    """A white plate in even light, which it reflects, whatever it is of."""
    plate = quad((-0.49, -0.49, 0.0), (0.98, 0.0, 0.0), (0.0, 0.98, 0.0), 1)
    walls, plates = grey(0.5, emission=1.0), (material, replace(material, transmission=0.0, clearcoat=0.0))
    light = [
        picture(resident_of([*box(), plate], [walls, of, *RARE]).generalised(), method=Method.PHOTON_GATHER, **COUNTS)
        for of in plates
    ]
    assert light[1].mean() > 1.0
    assert light[0].mean() == pytest.approx(light[1].mean(), rel=0.02)


@pytest.mark.parametrize("component", Component)
def test_a_coat_shows_a_lamp_and_the_walls(component: Component) -> None:
    """On a black floor, all of whose light is the coat's; where photons tell nothing of a wall, it shows nothing."""
    room = coated_room()
    seen = picture(room, method=Method.PHOTON_GATHER, component=component, samples=16, **COUNTS)[28:]
    paths = picture(room, method=Method.PATH, component=component, samples=256)[28:]
    lost = 0.9 if component is Component.INDIRECT else 1.0
    assert seen.mean() == pytest.approx(lost * paths.mean(), rel=0.08)


def test_at_rest_glass_is_seen_through() -> None:
    """A pane before a dark half of a room, which it would outshine if it were matt."""
    pane = quad((-0.49, -0.49, 0.0), (0.98, 0.0, 0.0), (0.0, 0.98, 0.0), 1)
    lamp = quad((-0.2, 0.49, 0.1), (0.4, 0.0, 0.0), (0.0, 0.0, 0.3), 2)
    glass = Material(transmission=1.0, roughness=0.3)
    room = resident_of([*box(), lamp, pane], [grey(0.3), glass, grey(0.0, 5.0), *RARE]).generalised()
    renderer = Renderer(room, SIZE, RenderSettings(method=Method.PHOTON_GATHER, **COUNTS))
    mean = Accumulation(SIZE[0] * SIZE[1], room.device)
    first, *_, rests = (renderer.render(CAMERA, mean).radiance() for _ in range(24))
    paths = picture(room, method=Method.PATH, samples=128)
    assert first.mean() > 2.0 * paths.mean()
    # The first four frames are of matt glass.
    assert rests.mean() == pytest.approx((20.0 * paths.mean() + 4.0 * first.mean()) / 24.0, rel=0.1)


def walked(room: DeviceScene, settings: RenderSettings) -> Floats:
    """Frames of a viewer that turns."""
    renderer = Renderer(room, SIZE, settings)
    view = renderer.new_view()
    cameras = [rotated(CAMERA, 0.5 * number) for number in range(3)]
    return np.stack([renderer.render(camera, view=view, walks=True).radiance() for camera in cameras])


def test_a_walk_flickers_less_as_it_keeps_where_it_gathers(room: DeviceScene) -> None:
    choice = {"method": Method.PHOTON_GATHER, **INDIRECT, **COUNTS, "sp_clusters": 200}
    kept = walked(room, RenderSettings(**choice))
    anew = walked(room, RenderSettings(**choice, skip=EVERY_SKIP.model_copy(update={"kept_clusters": False})))
    assert np.array_equal(kept[0], anew[0])
    every = walked(room, RenderSettings(**choice | {"sp_clusters": SIZE[0] * SIZE[1]}))
    assert flicker(kept, every).error_change < 0.85 * flicker(anew, every).error_change
    assert relative_error(kept[-1], every[-1]) < 1.2 * relative_error(anew[-1], every[-1])


def test_each_frame_makes_all_light_anew(room: DeviceScene) -> None:
    settings = RenderSettings(method=Method.PHOTON_GATHER, **INDIRECT, **COUNTS, sp_clusters=200)
    renderer = Renderer(room, SIZE, settings)
    first, again = (renderer.render(CAMERA, walks=True) for _ in range(2))
    assert {"photons", "illumination", "gather", "irradiance"} < set(first.stats.stage_ms)
    assert first.stats.counts["gather_rays"] == 200 * 64
    assert np.array_equal(first.radiance(), again.radiance())


def test_rays_of_centres_and_what_these_count_for_are_found_beside_photons(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = noted_stages(monkeypatch)
    picture(room, method=Method.PHOTON_GATHER, lambertian=True, **COUNTS)
    assert begun[:3] == ["gbuffer", "gather rays", "irradiance weights"]
    assert begun[3:8] == ["direct rays", "photons", "illumination", "gather waits", "irradiance waits"]


def test_photons_on_black_surfaces_are_some_of_those_wanted() -> None:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    room = resident_of([*box(), lamp], [grey(0.0), grey(0.0, 5.0)])
    settings = RenderSettings(method=Method.PHOTON_GATHER, **INDIRECT, photons=1000, gather_rays=16, bounces=2)
    frame = Renderer(room, SIZE, settings).render(CAMERA)
    assert frame.stats.counts["photons"] == 2 * 1000  # room for so many: light ends where it arrives
    assert not frame.radiance().any()


def test_direct_light_needs_no_photons(room: DeviceScene) -> None:
    settings = RenderSettings(method=Method.PHOTON_GATHER, component=Component.DIRECT, lambertian=True, samples=4)
    frame = Renderer(room, SIZE, settings).render(CAMERA)
    assert frame.stats.counts["photons"] == 0
    assert frame.radiance().mean() > 0.0
