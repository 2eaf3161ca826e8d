"""Edits that need kernels which have to be compiled: until these are there, who walks sees what it saw before."""

from gpu.core.kernel_loading import LateKernels
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.features import SceneFeatures, scene_features
from gpu.scene.edits import NO_EDITS, SceneEdits, shown
from gpu.settings import RenderSettings
from gpu.warm_up import compile_soon
from server.wire.worker import STILLS, SceneRef
from server.worker.loaded_scene import LoadedScene
from server.worker.worker import Report

COMPILING = "compiling kernels, which the first time takes a minute"


class LateEdits:
    """What viewers see of edits, and what is compiled for those."""

    def __init__(self) -> None:
        self._there: set[SceneFeatures] = set()  # whose kernels need not be compiled
        self._late: dict[SceneFeatures, LateKernels] = {}
        self._seen: dict[int, tuple[SceneRef, SceneEdits]] = {}  # by viewer
        self._waiting: set[tuple[int, object]] = set()  # viewers, and frames of theirs that wait

    def to_show(
        self, loaded: LoadedScene, edits: SceneEdits, viewer: int, report: Report, *, walks: bool
    ) -> SceneEdits:
        """`edits` of a scene once their kernels are there; until then, if it walks, those that a viewer saw last: who
        does not walk waits, while others have the device, until it walks on: its frames are shown in their order.

        Raises UserError for what the scene has not.
        """
        if walks:
            self._end_waits(viewer)
        if self._seen.get(viewer) == (loaded.ref, edits):
            return edits
        late = self._missing(loaded, edits)
        if late is not None and not walks:
            report(COMPILING, 0.8)
            walks = self._waits_in_vain(late, viewer)
        if late is not None and walks:
            before = self._seen.get(viewer)
            return before[1] if before is not None and before[0] == loaded.ref else NO_EDITS
        self._seen[viewer] = loaded.ref, edits
        return edits

    def leave(self, viewer: int) -> None:
        """Forget what a viewer saw."""
        self._seen.pop(viewer, None)
        self._end_waits(viewer)

    def _waits_in_vain(self, late: LateKernels, viewer: int) -> bool:
        """Wait until kernels are compiled; whether the viewer wants something else before."""
        wait = viewer, object()
        self._waiting.add(wait)
        try:
            DEVICE_SHARING.wait_for(lambda: late.compiled or wait not in self._waiting)
        finally:
            self._waiting.discard(wait)
        return not late.compiled

    def _end_waits(self, viewer: int) -> None:
        if viewer > STILLS:  # which many share
            self._waiting = {wait for wait in self._waiting if wait[0] != viewer}

    def _missing(self, loaded: LoadedScene, edits: SceneEdits) -> LateKernels | None:
        """Those that are being compiled for a scene with `edits`, from now on if need be; None where none are."""
        base, scene = loaded.device_scene, shown(loaded.scene, edits)
        features = scene_features(scene, lambertian=False, constants=base.constants)
        if features in self._there or features == base.own_features(lambertian=False):
            return None
        if features not in self._late:
            state = base.generalised(general=False).edited(scene)
            if (late := compile_soon(state, RenderSettings())) is None:
                self._there.add(features)
                return None
            self._late[features] = late
        if self._late[features].compiled:
            del self._late[features]
            self._there.add(features)
            return None
        return self._late[features]
