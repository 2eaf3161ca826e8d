"""A scene on the device, with its lights."""

from dataclasses import dataclass, field

import warp as wp

from gpu.core.stages import new_number
from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.types import Scene
from gpu.vpl.light_sets import LightSets
from server.wire.worker import SceneRef


@dataclass(eq=False)
class LoadedScene:
    """A scene in one state, with `edits` or as its file is, and what all renderers of that share.

    number: of its arrays alone, which may become those of another state.
    """

    ref: SceneRef
    scene: Scene
    device_scene: DeviceScene
    light_sets: LightSets
    edits: SceneEdits = NO_EDITS
    number: int = field(default_factory=new_number)


def build(ref: SceneRef, scene: Scene, device: wp.Device) -> LoadedScene:
    """Put a scene on the device; its lights are traced when the first renderer wants them."""
    device_scene = DeviceScene(scene, str(device))
    return LoadedScene(ref, scene, device_scene, LightSets(device_scene))


def edit(loaded: LoadedScene, edits: SceneEdits, before: LoadedScene | None = None) -> LoadedScene:
    """The scene of `loaded`, which has none, with `edits`; both share geometry. UserError for what it has not.

    before: with other edits, which nobody needs any more: becomes what is wanted where its arrays are as large and
    kernels need to know no more, so that its renderers go on.
    """
    scene = edited(loaded.scene, edits)
    device_scene = loaded.device_scene.edited(scene)
    if before is not None and before.light_sets.follow(device_scene):
        before.scene, before.edits = scene, edits
        return before
    return LoadedScene(loaded.ref, scene, device_scene, LightSets(device_scene), edits)
