"""Lights that change are seen in the next frame, and clusters go on."""

import numpy as np
import pytest
import warp as wp
from pictures import QUALITY, SIZE
from scenes import box, grey, resident_of, results
from walking import pose

from gpu.core.kahan import Sum, kahan_add
from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import LightData
from gpu.methods.method import RenderSetup
from gpu.methods.rsm_disks import RsmDisks
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.scene.types import Floats, Light, LightKind
from gpu.settings import Component, Method, RenderSettings, Skips
from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.light_sets import LightSets
from gpu.vpl.vpl_clusters import VplClusters

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


@wp.kernel
def floor_light_kernel(first: int, vpls: VplClusters, out: wp.array[wp.vec3]) -> None:
    """One thread a point of the floor: its light, were nothing hidden."""
    point = first + wp.tid()
    position = wp.vec3(0.04 * float(point % 20) - 0.4, -0.5, 0.04 * float(point // 20) - 0.4)
    total = Sum()
    for cluster in range(vpls.count):
        total = kahan_add(total, unoccluded_irradiance(position, wp.vec3(0.0, 1.0, 0.0), vpls, cluster))
    out[point] = total.total


@pytest.mark.parametrize(("moves", "most"), [("camera", 0.35), ("bulb", 1.2)])
def test_clusters_of_kept_seeds_flicker_no_more_than_ones_that_begin_anew(moves: str, most: float) -> None:
    """What the view sees says where seeds are, so light changes with it; kept ones go along with a bulb that moves, as
    those do that are found anew while the camera rests.
    """
    device_scene = room_of(bulb(0.1))
    counts = sample_counts_of(SETTINGS, device_scene.device)

    def change(skip: Skips) -> float:
        settings = SETTINGS.model_copy(update={"skip": skip, "indirect_shadows": False, "smooth": False})
        light_sets = LightSets(device_scene)
        setup = RenderSetup(device_scene, light_sets, SIZE, settings, counts, lambda what, share: None)
        method, stages, floor = RsmDisks(setup), Stages(device_scene.device), []
        view = method.new_view()
        for step in range(8):
            if moves == "bulb":
                move(light_sets, bulb(0.1 - 0.01 * step))
            view.set_camera(pose(2.0 * step if moves == "camera" else 0.0), walks=True)
            stages.start_frame()
            method.render(view, stages, 0)
            floor.append(results(floor_light_kernel, 400, [method.lights.vpls], wp.vec3))
        # Of a bulb that goes evenly light changes evenly, and without it not at all.
        return float(np.abs(np.diff(floor[3:], n=2, axis=0)).mean() / np.mean(floor))

    kept, anew = change(Skips()), change(Skips(kept_clusters=False))
    assert 0.0 < kept < most * anew
