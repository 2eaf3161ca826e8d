"""Errors that a user can cause and mend; each message names the thing, the place in it and what to do."""

import re

MOST_PLACE, MOST_PROBLEM = 500, 2000  # characters: what a file brings may be quoted, and is cut
_BREAK = re.compile(r"[\t-\r\x85\u2028\u2029]")
_NO_TEXT = re.compile(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def brief(text: str, most: int) -> str:
    """`text` in one line of at most so many characters, the last of them "…" if it is cut.

    What belongs to no text (control characters, halves of characters, turns of the direction of writing) is "�".
    """
    # One more than fits tells that it is cut: what is far too long is not looked through.
    line = _NO_TEXT.sub("�", _BREAK.sub(" ", text[: most + 1]))
    return line if len(line) <= most else line[: most - 1] + "…"


class UserError(Exception):
    """Base of every error that bad input causes: shown as one line, never as a traceback."""


class SceneError(UserError):
    """A scene cannot be loaded or rendered.

    `source` is the file or scene name, `field` the place in it (a JSON path such as "meshes[2].primitives[0]"),
    `problem` what is wrong there and what to do about it.
    """

    def __init__(self, source: str, field: str, problem: str) -> None:
        self.source, self.field, self.problem = source, brief(field, MOST_PLACE), brief(problem, MOST_PROBLEM)
        super().__init__(": ".join(part for part in (source, self.field, self.problem) if part))


class ForbiddenError(SceneError):
    """A scene needs more than a limit allows, or a file outside its folder: no part is left out to go on without."""


class DeviceError(UserError):
    """The wanted compute device does not exist or cannot be used."""


class OutOfMemoryError(UserError):
    """The device has too little memory for what was asked; the message says what asks for less."""


class ImageError(UserError):
    """An image cannot be read, written or compared."""
