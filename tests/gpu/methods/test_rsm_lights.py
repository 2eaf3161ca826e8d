"""Lights that change are seen in the next frame, and clusters go on."""

import numpy as np
import pytest
from pictures import QUALITY, SIZE
from scenes import box, grey, resident_of
from walking import pose

from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import LightData
from gpu.renderer import Renderer
from gpu.scene.types import Floats, Light, LightKind
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.light_sets import LightSets

SETTINGS = RenderSettings(
    **{**QUALITY, "component": Component.INDIRECT, "method": Method.RSM_DISKS, "near_field": False}
)


def bulb(x: float, strength: float = 1.0) -> Light:
    return Light("bulb", LightKind.POINT, (strength,) * 3, position=(x, 0.2, 0.0))


def room_of(light: Light) -> DeviceScene:
    return resident_of(box(), [grey(0.7)], lights=[light])


def move(light_sets: LightSets, light: Light) -> None:
    """Have the table's only light be this one, in the array that is there."""
    lights = light_sets.table.lights.numpy()
    lights["position"], lights["intensity"] = light.position, light.intensity
    light_sets.table.lights.assign(lights.astype(LightData.numpy_dtype()))


def rendered(renderer: Renderer, *, walks: bool) -> Floats:
    """The next frame of a view that stays; the light may have changed."""
    view = renderer.new_view() if not walks else None
    return renderer.render(pose(0), view=view, walks=walks).radiance().astype(np.float64)


def test_a_frame_is_lit_by_the_lights_as_they_are() -> None:
    first, second = bulb(-0.2), bulb(0.2, 2.0)
    device_scene = room_of(first)
    light_sets = LightSets(device_scene)
    renderer = Renderer(device_scene, SIZE, SETTINGS, light_sets=light_sets)
    before = rendered(renderer, walks=False)
    move(light_sets, second)
    after = rendered(renderer, walks=False)
    fresh = rendered(Renderer(room_of(second), SIZE, SETTINGS), walks=False)
    assert after.tobytes() == fresh.tobytes() != before.tobytes()
    assert after.mean() == pytest.approx(2.0 * before.mean(), rel=0.1)


def test_a_table_without_power_lights_nothing() -> None:
    frame = Renderer(room_of(bulb(0.0, 0.0)), SIZE, SETTINGS).render(pose(0))
    assert (frame.radiance() == 0.0).all()
    assert frame.stats.counts["vpl_clusters"] == 0
