"""What differs from the files of scenes, for all who look at them or one viewer."""

import logging
from collections.abc import Callable, Mapping

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, Editable, SceneEdits, check
from server.refusals import TooBusyError
from server.wire.browser import SceneInfo, ScenePatch
from server.wire.scene_patch import patched
from server.wire.worker import SceneRef

log = logging.getLogger("lumenwalk.edits")
MOST_EDITED = 64  # scenes whose edits are remembered; those that were not changed for longest are forgotten


def editable(info: SceneInfo) -> Editable:
    """What can be edited of a scene that is described."""
    objects = {it.id: (it.box.min, it.box.max) for it in info.objects}
    lights, materials = {light.id: light.form for light in info.lights}, {it.id: it for it in info.materials}
    animations = [animation.id for animation in info.animations]
    return Editable(lights, materials, objects, (info.bounds.min, info.bounds.max), animations)


class EditedScenes:
    """The edits of each scene, those that viewers have of their own, and who is to be told of changes. A file that
    changes, or is read otherwise, is another scene.
    """

    def __init__(self, most_own: int = 8) -> None:
        """most_own: viewers that may have edits of their own."""
        self._edits: dict[SceneRef, SceneEdits] = {}  # in the order of their last change
        self._restored = set[SceneRef]()  # whose edits nobody has held against what is in the scene
        self._own: dict[int, tuple[SceneRef, SceneEdits]] = {}  # by viewer
        self._most_own = most_own
        self.listeners: set[Callable[[SceneRef], None]] = set()

    @property
    def all(self) -> dict[SceneRef, SceneEdits]:
        """Those that all see, the longest unchanged first."""
        return dict(self._edits)

    def restore(self, edits: Mapping[SceneRef, SceneEdits]) -> None:
        """Have edits of an earlier service be those of all, before anybody looks."""
        self._edits.update(edits)
        self._restored.update(edits)

    def learn(self, scene: SceneRef, info: SceneInfo) -> None:
        """A scene was read: edits of an earlier service end that another program made of what it has not any more."""
        if scene in self._restored:
            self._restored.discard(scene)
            try:
                check(self.of(scene), editable(info))
            except UserError as error:
                log.warning("%s: kept edits do not fit the scene any more, and end: %s", scene.id, error)
                self._set(scene, NO_EDITS)

    def of(self, scene: SceneRef, viewer: int | None = None) -> SceneEdits:
        """All that differs from a scene's file now, for a viewer or for all who have no edits of their own."""
        if viewer is not None and self.is_own(scene, viewer):
            return self._own[viewer][1]
        return self._edits.get(scene, NO_EDITS)

    def is_own(self, scene: SceneRef, viewer: int) -> bool:
        """Whether a viewer's edits of a scene are its own."""
        return viewer in self._own and self._own[viewer][0] == scene

    def begin_own(self, scene: SceneRef, viewer: int) -> None:
        """Have a viewer's edits be its own from now on, which begin as those of all; TooBusyError if too many have."""
        if self.is_own(scene, viewer):
            return
        if len(self._own) >= self._most_own:
            raise TooBusyError(
                f"{len(self._own)} viewers have edits of their own, as many as may; edit for all, or wait"
            )
        self._own[viewer] = scene, self.of(scene)

    def end_own(self, viewer: int, *, share: bool = False) -> None:
        """Have a viewer see again what all see; share: and these what were its own."""
        scene, edits = self._own.pop(viewer, (None, NO_EDITS))
        if scene is not None and share:
            self._set(scene, edits)

    def change(self, scene: SceneRef, info: SceneInfo, patch: ScenePatch, viewer: int | None = None) -> SceneEdits:
        """Have `patch` in force from the next frame on; the edits then. info: what is in the scene.

        UserError, which names the field, for what it has not or cannot be: then nothing changes.
        """
        edits = patched(self.of(scene, viewer), patch)
        check(edits, editable(info))
        if viewer is not None and self.is_own(scene, viewer):
            self._own[viewer] = scene, edits
        else:
            self._set(scene, edits)
        return edits

    def _set(self, scene: SceneRef, edits: SceneEdits) -> None:
        self._edits.pop(scene, None)
        if edits != NO_EDITS:
            self._edits[scene] = edits
        while len(self._edits) > MOST_EDITED:
            forgotten = next(iter(self._edits))
            del self._edits[forgotten]
            self._tell(forgotten)
        self._tell(scene)

    def _tell(self, scene: SceneRef) -> None:
        for listener in tuple(self.listeners):
            listener(scene)
