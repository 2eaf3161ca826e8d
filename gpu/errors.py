"""Errors that a user can cause and mend; each message names the thing, the place in it and what to do."""


class UserError(Exception):
    """Base of every error that bad input causes: shown as one line, never as a traceback."""


class SceneError(UserError):
    """A scene cannot be loaded or rendered.

    `source` is the file or scene name, `field` the place in it (a JSON path such as "meshes[2].primitives[0]"),
    `problem` what is wrong there and what to do about it.
    """

    def __init__(self, source: str, field: str, problem: str) -> None:
        self.source, self.field, self.problem = source, field, problem
        super().__init__(": ".join(part for part in (source, field, problem) if part))


class ForbiddenError(SceneError):
    """A scene needs more than a limit allows, or a file outside its folder: no part is left out to go on without."""


class DeviceError(UserError):
    """The wanted compute device does not exist or cannot be used."""


class OutOfMemoryError(UserError):
    """The device has too little memory for what was asked; the message says what asks for less."""


class ImageError(UserError):
    """An image cannot be read, written or compared."""
