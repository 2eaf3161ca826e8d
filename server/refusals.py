"""Why a request is refused, each kind with the HTTP status that server.errors gives it."""

from collections.abc import Mapping
from typing import Any

from gpu.errors import UserError


class UnknownSceneError(UserError):
    """No scene has this id (404)."""


class UnknownJobError(UserError):
    """No job has this id (404)."""


class ForbiddenError(UserError):
    """It is not for clients to change (403)."""


class InUseError(UserError):
    """Somebody uses what should go (409)."""


class NotYetError(UserError):
    """There is no result to give (409)."""


class TooLargeError(UserError):
    """A body is larger than this service takes (413)."""


class NoRoomError(UserError):
    """The device or the uploads folder has no room for it (507)."""


class TooSlowError(UserError):
    """A body did not arrive in time (408)."""


class TooBusyError(Exception):
    """As much waits as may (429)."""


class NotAcceptableError(Exception):
    """None of the formats that the client takes can be written (406)."""


def reason(problem: Mapping[str, Any]) -> str:
    """What is wrong with a field, of one of the problems that pydantic tells; not which field."""
    about = problem.get("ctx", {})
    match problem["type"]:
        case "extra_forbidden":
            return "is not known here; check its name"
        case "missing":
            return "is missing"
        case "too_short":
            return f"needs {about['min_length']} or more, has {about['actual_length']}"
        case "too_long":
            return f"may have {about['max_length']} or fewer, has {about['actual_length']}"
        case "tuple_type" | "list_type":
            return "must be an array"
        case "union_tag_not_found":
            return f"{about['discriminator']} is missing"
        case "union_tag_invalid":
            return f"{about['discriminator']} must be one of {about['expected_tags']}, not {about['tag']!r}"
        case _:
            words = str(problem["msg"]).removeprefix("Value error, ")
            return words.replace("Input should", "must").replace("String should", "must")
