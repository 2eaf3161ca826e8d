"""What differs from the files of scenes, for all who look at them or one viewer."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

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


def fitting(edits: SceneEdits, there: Editable) -> tuple[SceneEdits, list[str]]:
    """What of `edits` can be of a scene, and the fields of what cannot: each alone, then all objects together."""
    kinds = {kind: getattr(edits, kind) for kind in ("lights", "materials", "objects")}
    gone = [f"{kind}.{one}" for kind, of in kinds.items() for one in of if not _fits({kind: {one: of[one]}}, there)]
    left_out = set(gone)
    made: dict[str, Any] = {
        kind: {one: of[one] for one in of if f"{kind}.{one}" not in left_out} for kind, of in kinds.items()
    }
    moment = {"time": edits.time, "animation": edits.animation}
    if _fits(moment, there):
        made |= moment
    else:
        gone.append("time")
    if not _fits(made, there):
        gone.append("objects")
        made["objects"] = {}
    return SceneEdits.model_construct(**made), gone


def _fits(part: dict[str, Any], there: Editable) -> bool:
    try:
        check(SceneEdits.model_construct(**part), there)
    except UserError:
        return False
    return True


class EditedScenes:
    """The edits of each scene, those that viewers have of their own, and who is to be told of changes. A file that is
    read otherwise is another scene, and so is one that changes, which takes over the edits that fit it.
    """

    def __init__(self, most_own: int = 8) -> None:
        """most_own: viewers that may have edits of their own."""
        self._edits: dict[SceneRef, SceneEdits] = {}  # in the order of their last change
        self._restored = set[SceneRef]()  # whose edits were not held against what is in the scene
        self._current: dict[SceneRef, SceneRef] = {}  # the version of a file that was loaded last, where one is edited
        self._own: dict[int, tuple[SceneRef, SceneEdits]] = {}  # by viewer
        self._most_own = most_own
        self.listeners: set[Callable[[SceneRef], None]] = set()

    @property
    def all(self) -> dict[SceneRef, SceneEdits]:
        """Those that all see of files as they are now, the longest unchanged first."""
        return {scene: edits for scene, edits in self._edits.items() if self._newest(scene) == scene}

    def restore(self, edits: Mapping[SceneRef, SceneEdits]) -> None:
        """Have edits of an earlier service be those of all, before anybody looks."""
        self._edits.update(edits)
        self._restored.update(edits)
        self._current.update({_any_version(scene): scene for scene in edits})

    def unproven(self, scene: SceneRef) -> bool:
        """Whether there are edits of a scene of which it is to be learnt whether they fit."""
        return scene in self._restored or self._newest(scene) != scene

    def learn(self, scene: SceneRef, info: SceneInfo) -> None:
        """A scene was loaded: it has what fits of the edits of its file as that was, or of an earlier service."""
        if not self.unproven(scene):
            return
        edits, gone = fitting(self.of(self._newest(scene)), editable(info))
        self._restored.discard(scene)
        self._current[_any_version(scene)] = scene
        if gone:
            log.warning("%s: edits that do not fit its file any more end: %s", scene.id, ", ".join(gone)[:500])
        if edits != self.of(scene):
            self._set(scene, edits)

    def take_over(self, before: SceneRef, scene: SceneRef) -> None:
        """Have the edits of one scene be those of another, as far as they fit that once it is loaded."""
        self._restored.add(scene)
        self._set(scene, self.of(before))

    def _newest(self, scene: SceneRef) -> SceneRef:
        return self._current.get(_any_version(scene), scene)

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

    def end_own(self, viewer: int, *, share: bool = False) -> bool:
        """Have a viewer see again what all see; share: and these what were its own, if it had some, which is told."""
        scene, edits = self._own.pop(viewer, (None, NO_EDITS))
        if scene is None or not share:
            return False
        self._set(scene, edits)
        return True

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
            self._current.setdefault(_any_version(scene), scene)
        while len(self._edits) > MOST_EDITED:
            forgotten = next(iter(self._edits))
            del self._edits[forgotten]
            self._tell(forgotten)
        edited = {*map(_any_version, self._edits)}
        self._current = {file: newest for file, newest in self._current.items() if file in edited}
        self._restored &= {*self._edits}
        self._tell(scene)

    def _tell(self, scene: SceneRef) -> None:
        for listener in tuple(self.listeners):
            listener(scene)


def _any_version(scene: SceneRef) -> SceneRef:
    return replace(scene, stamp=0)
