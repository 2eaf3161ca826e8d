"""What the engine is doing, for those who wait for frames."""

from dataclasses import dataclass
from enum import StrEnum


class EngineState(StrEnum):
    """Whether frames can be had."""

    STARTING = "starting"
    READY = "ready"
    RECOVERING = "recovering"
    FAILED = "failed"


@dataclass(frozen=True)
class Activity:
    """The engine's state and, while something takes long, what that is and how far it is, from 0 to 1."""

    state: EngineState
    text: str = ""
    fraction: float = 0.0


READY = Activity(EngineState.READY)
RECOVERING = Activity(EngineState.RECOVERING, "starting the renderer again")
