from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, scene_of

from gpu.scene.lighting.added_daylight import has_sun, overhead_sun, with_daylight
from gpu.scene.lighting.default_light import SOFT_SKY
from gpu.scene.types import Environment, Light, LightKind, Sky

BULB = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0))


def test_what_is_wanted_is_added_after_what_is_there() -> None:
    scene = scene_of(box(), [grey(0.5)], lights=[BULB])
    assert with_daylight(scene, sun=False, sky=False) is scene
    both = with_daylight(scene, sun=True, sky=True)
    assert both.lights[:-1] == (BULB,)
    assert both.sky == SOFT_SKY
    assert not has_sun(scene)
    assert has_sun(both)


def test_a_sun_is_as_bright_as_goes_with_its_sky() -> None:
    """The sun overhead sends 3 times as much to level ground as its sky does, about 100 klx beside 33."""
    assert overhead_sun(None) == overhead_sun(SOFT_SKY)
    luminance = np.array([0.2126, 0.7152, 0.0722])
    for sky, level in ((Sky((0.6, 1.2, 1.8)), 1.0), (Environment("even", np.full((8, 16, 3), 2.0, np.float32)), 2.0)):
        sun = overhead_sun(sky)
        assert luminance @ sun.intensity == pytest.approx(2.64 * np.pi * level, rel=0.01)
        assert sun.direction == (0.0, -1.0, 0.0)
        assert sun.intensity[0] > sun.intensity[1] > sun.intensity[2]
    tinted = replace(Environment("even", np.full((8, 16, 3), 2.0, np.float32)), tint=(0.5, 0.5, 0.5))
    assert overhead_sun(tinted) == overhead_sun(Environment("even", np.ones((8, 16, 3), np.float32)))
