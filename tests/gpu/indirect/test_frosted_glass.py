"""What frosted glass shows in single frames: in an evenly lit room, what it reflects and lets through of that."""

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, grey, quad, resident_of
from walls import CPU

from gpu.direct.direct_light import direct_samples
from gpu.indirect.lobe_light import known_light
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Material
from gpu.vpl.light_sets import LightSetChoice, LightSets

SIZE = (24, 16)
CAMERA = look_at((0.1, 0.1, 0.3), (0.0, 0.0, -0.1), yfov_degrees=30.0)
COLOUR = np.array([1.0, 0.95, 0.9])


def shown(transmission: float = 1.0, *, direct: bool = True) -> tuple[Doubles, Doubles]:
    """Of a coloured frosted sheet in a room whose walls emit 1/π and reflect half: what it shows besides what is matt
    of it, in parts of the light there is, and the albedo of that, (pixel, 3) each.
    """
    glass = Material(base_color=(*COLOUR, 1.0), transmission=transmission, roughness=0.4, specular=0.0)
    sheet = quad([-0.49, -0.49, 0.0], [0.98, 0, 0], [0, 0.98, 0], 1)
    device_scene = resident_of([*box(), sheet], [grey(0.5, emission=1.0 / np.pi), glass])
    lights = LightSets(device_scene)
    choice = LightSetChoice(vpls=5000, vpl_clusters=100, bounces=8, seed=0, lambertian=False)
    cache = lights.radiosity(lights.made(choice, lambda what, fraction: None))
    view = FrameView(device_scene, SIZE, lambertian=False, reads_radiosity=True)
    view.set_camera(CAMERA)
    view.find_shading_points()
    moment = wp.zeros(1, dtype=int, device=CPU)
    assert view.gloss
    known = known_light(lights.table, cache, direct=direct)
    view.gloss.trace(view.scene, view.camera, view.gbuffer, known, direct_samples(1, moment, 0))
    view.gloss.share(view.gbuffer)
    view.radiance.zero_()
    view.gloss.add(view.gbuffer, view.radiance)
    return view.radiance.numpy() * np.pi / 2.0, view.gbuffer.albedo.numpy()


def test_frosted_glass_shows_what_is_before_and_behind_it() -> None:
    """About nine tenths goes through, tinted. Half of the light is of the emitters themselves."""
    light, matt = shown()
    assert np.allclose(matt, 0.0)
    assert light.mean(axis=0) == pytest.approx(0.08 + 0.9 * COLOUR, rel=0.06)
    reflected, _ = shown(direct=False)
    assert reflected.mean(axis=0) == pytest.approx((0.08 + 0.9 * COLOUR) / 2.0, rel=0.1)


def test_the_rest_of_what_is_partly_glass_is_matt() -> None:
    light, matt = shown(0.3)
    assert np.allclose(matt, 0.7 * COLOUR, atol=1e-3)
    assert light.mean(axis=0) == pytest.approx(0.3 * (0.08 + 0.9 * COLOUR), rel=0.06)
