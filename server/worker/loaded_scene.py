"""A scene on the device, with its lights."""

from dataclasses import dataclass

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.types import Scene
from gpu.vpl.light_sets import LightSets
from server.wire.worker import SceneRef


@dataclass(frozen=True)
class LoadedScene:
    """A scene in one state, with `edits` or as its file is, and what all renderers of that share."""

    ref: SceneRef
    scene: Scene
    device_scene: DeviceScene
    light_sets: LightSets
    edits: SceneEdits = NO_EDITS


def build(ref: SceneRef, scene: Scene, device: wp.Device) -> LoadedScene:
    """Put a scene on the device; its lights are traced when the first renderer wants them."""
    device_scene = DeviceScene(scene, str(device))
    return LoadedScene(ref, scene, device_scene, LightSets(device_scene))


def edit(loaded: LoadedScene, edits: SceneEdits) -> LoadedScene:
    """The scene of `loaded`, which has none, with `edits`; both share geometry. UserError for what it has not."""
    scene = edited(loaded.scene, edits)
    device_scene = loaded.device_scene.edited(scene)
    return LoadedScene(loaded.ref, scene, device_scene, LightSets(device_scene), edits)
