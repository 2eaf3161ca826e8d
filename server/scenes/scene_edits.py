"""What differs from the files of scenes, for all who look at them, as long as the service runs."""

from collections.abc import Callable

from gpu.scene.edits import NO_EDITS, Editable, SceneEdits, check
from server.wire.browser import SceneInfo, ScenePatch
from server.wire.scene_patch import patched
from server.wire.worker import SceneRef

MOST_EDITED = 64  # scenes whose edits are remembered; those that were not changed for longest are forgotten


class EditedScenes:
    """The edits of each scene, and who is to be told of changes. A file that changes, or is read otherwise, is another
    scene.
    """

    def __init__(self) -> None:
        self._edits: dict[SceneRef, SceneEdits] = {}  # in the order of their last change
        self.listeners: set[Callable[[SceneRef], None]] = set()

    def of(self, scene: SceneRef) -> SceneEdits:
        """All that differs from a scene's file now."""
        return self._edits.get(scene, NO_EDITS)

    def change(self, scene: SceneRef, info: SceneInfo, patch: ScenePatch) -> SceneEdits:
        """Have `patch` in force from the next frame on; the edits then. info: what is in the scene.

        UserError, which names the field, for what it has not or cannot be: then nothing changes.
        """
        edits = patched(self.of(scene), patch)
        objects = {it.id: (it.box.min, it.box.max) for it in info.objects}
        bounds = info.bounds.min, info.bounds.max
        lights, materials = {light.id: light.form for light in info.lights}, {it.id: it for it in info.materials}
        animations = [animation.id for animation in info.animations]
        check(edits, Editable(lights, materials, objects, bounds, animations))
        self._edits.pop(scene, None)
        if edits != NO_EDITS:
            self._edits[scene] = edits
        while len(self._edits) > MOST_EDITED:
            forgotten = next(iter(self._edits))
            del self._edits[forgotten]
            self._tell(forgotten)
        self._tell(scene)
        return edits

    def _tell(self, scene: SceneRef) -> None:
        for listener in tuple(self.listeners):
            listener(scene)
