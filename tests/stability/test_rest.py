"""A walk comes to rest: no part of the picture brightens or darkens much from its last frame to the mean at rest.

Direct light of a small picture, in few samples: lamps' edges and dark corners differ most. What else does is in
docs/history/rest.md.
"""

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.settings import Component, RenderSettings
from tests.bench.still import tile_changes
from tests.bench.temporal import walk

SIZE, WALKS, RESTS = (64, 64), 12, 12
# Four seeds have 0.014 to 0.016 and 0.14 to 0.17; without gpu.denoise.lost_light 0.017 to 0.018 and 0.22 to 0.24.
MOST_OF_HALF, MOST_OF_NINE_IN_TEN = 0.025, 0.19


def test_parts_of_a_picture_stay_as_bright_as_a_walk_comes_to_rest() -> None:
    device_scene = DeviceScene(load_scene("cornell-box"), "cpu")
    camera, extent = device_scene.scene.cameras[0], 1.0 / device_scene.scene.placement.scale
    renderer = Renderer(device_scene, SIZE, RenderSettings(component=Component.DIRECT))
    for step in reversed(walk(camera, extent, WALKS)):
        last = renderer.render(step, walks=True).radiance()
    mean = Accumulation(SIZE[0] * SIZE[1], device_scene.device)
    for number in range(RESTS):
        rests = renderer.render(camera, mean, walks=number == 0)
    changes = tile_changes(rests.radiance(), last)
    assert np.median(changes) < MOST_OF_HALF
    assert np.quantile(changes, 0.9) < MOST_OF_NINE_IN_TEN
