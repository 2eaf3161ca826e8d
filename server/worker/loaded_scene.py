"""A scene on the device, with its lights."""

from dataclasses import dataclass

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Scene
from gpu.vpl.light_sets import LightSets
from server.wire.worker import SceneRef


@dataclass(frozen=True)
class LoadedScene:
    """A scene, and what all renderers of it share."""

    ref: SceneRef
    scene: Scene
    device_scene: DeviceScene
    light_sets: LightSets


def build(ref: SceneRef, scene: Scene, device: wp.Device) -> LoadedScene:
    """Put a scene on the device; its lights are traced when the first renderer wants them."""
    device_scene = DeviceScene(scene, str(device))
    return LoadedScene(ref, scene, device_scene, LightSets(device_scene))
