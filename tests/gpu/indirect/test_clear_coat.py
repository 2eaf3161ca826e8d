"""What clear coats show in single frames: as much as `path` says, by what is below and by the coat itself."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from frame_view import FrameView
from scenes import RARE, box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import direct_samples
from gpu.indirect.clear_coat import add_clear_coat
from gpu.indirect.lobe_light import known_light
from gpu.lights.light_table import LightTable
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles
from gpu.vpl.light_sets import LightSetChoice, LightSets
from gpu.vpl.radiosity_cache import RadiosityCache

SIZE = (24, 16)
CAMERA = look_at((0.2, 0.1, 0.3), (0.0, 0.0, -0.05), yfov_degrees=25.0)


@cache
def room(coat_roughness: float) -> tuple[DeviceScene, LightTable, RadiosityCache]:
    """A white plate with a coat in a room whose walls emit 1/π and reflect half, so that light of 2/π is all around;
    and its light.
    """
    coated = replace(grey(1.0), clearcoat=0.8, clearcoat_roughness=coat_roughness)
    plate = quad([-0.49, -0.49, 0.0], [0.98, 0, 0], [0, 0.98, 0], 1)
    device_scene = resident_of([*box(), plate], [grey(0.5, emission=1.0 / np.pi), coated, *RARE]).generalised()
    lights = LightSets(device_scene)
    choice = LightSetChoice(vpls=20_000, vpl_clusters=200, bounces=8, seed=0, lambertian=False)
    return device_scene, lights.table, lights.radiosity(lights.made(choice, lambda what, fraction: None))


def shown(
    coat_roughness: float, *, direct: bool, count: int = 4, number: int = 0, followed: bool = False
) -> tuple[Doubles, Doubles]:
    """Of each pixel of the plate: what the coat leaves of what is below, and what it adds, in parts of the light.

    count: samples of direct light; number: of the frame; followed: as of KnownLight, without indirect light.
    """
    device_scene, table, cache = room(coat_roughness)
    view = FrameView(device_scene, SIZE, lambertian=False, traces_lobes=True)
    view.set_camera(CAMERA)
    view.find_shading_points()
    frame, known = view.frame, known_light(table, None if followed else cache, direct=direct)
    known.followed = followed
    frame.frame_index.fill_(number)
    samples = direct_samples(count, frame.frame_index, 0)
    add_clear_coat(frame.scene, SIZE, frame.gbuffer, known, samples, view.radiance, frame.features)
    return frame.gbuffer.throughput.numpy()[:, 0].astype(float), view.radiance.numpy()[:, 0] * np.pi / 2.0


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_a_coat_shows_what_it_takes_from_below(roughness: float) -> None:
    """Half of the light around is of emitters, which direct light has and indirect light has not."""
    below, coat = shown(roughness, direct=True)
    assert np.all((below > 0.5) & (below < 0.97))
    assert coat.mean() == pytest.approx(1.0 - below.mean(), rel=0.05)
    below, coat = shown(roughness, direct=False)
    assert coat.mean() == pytest.approx((1.0 - below.mean()) / 2.0, rel=0.05)


def test_where_chains_go_on_by_coats_these_have_no_indirect_light_besides() -> None:
    direct = shown(0.0, direct=True)[1] - shown(0.0, direct=False)[1]
    assert shown(0.0, direct=True, followed=True)[1] == pytest.approx(direct, abs=1e-6)


def test_frames_have_samples_of_direct_light_of_their_own() -> None:
    """The second frame of two samples has the third and the fourth."""

    def direct_light(count: int, number: int) -> Doubles:
        whole, indirect = (shown(0.3, direct=direct, count=count, number=number)[1] for direct in (True, False))
        return whole - indirect

    both = (direct_light(1, 2) + direct_light(1, 3)) / 2.0
    assert direct_light(2, 1) == pytest.approx(both, abs=1e-5)
    assert not np.allclose(direct_light(1, 2), direct_light(1, 3), atol=1e-2)
