"""What an engine tells those who use it: what it does, on which device, and what that holds."""

from collections.abc import Callable

from server.render.activity import Activity, EngineState
from server.wire.worker import Holdings, SceneRef

NOTHING = Holdings(0, 0, ())


class Standing:
    """How an engine stands now; `listeners` are called when its activity changes."""

    def __init__(self) -> None:
        self._activity = Activity(EngineState.STARTING, "starting")
        self.listeners: set[Callable[[], None]] = set()
        self.restarts = 0
        self.unusable = False  # no worker can start, by the user's fault
        self.device = ""
        self.busy_seconds = 0.0  # of device time, by all workers together
        self.memory = (0, 0)  # of the device: used and all [bytes]; not known before it is ready
        self.scenes: tuple[SceneRef, ...] = ()  # on the device, the one used last at the end

    @property
    def activity(self) -> Activity:
        """What the engine is doing now."""
        return self._activity

    @property
    def ready(self) -> bool:
        """Whether jobs are taken now."""
        return self._activity.state is EngineState.READY

    @property
    def cuda(self) -> bool:
        """Whether the worker has a GPU, as far as it has said so."""
        return "cuda" in self.device

    def set_activity(self, activity: Activity) -> None:
        """It does something else now."""
        if activity == self._activity:
            return
        self._activity = activity
        for listener in tuple(self.listeners):
            listener()

    def holds(self, holdings: Holdings) -> None:
        """The worker says what is on the device."""
        self.memory, self.scenes = (holdings.memory_used, holdings.memory_total), holdings.scenes
