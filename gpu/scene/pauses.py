"""Where long work on a scene may let others have their turn: whoever has it done says how."""

from collections.abc import Callable

Pause = Callable[[], None]
EVERY = 1024  # short steps between two pauses


def go_on() -> None:
    """Nobody else wants a turn."""
