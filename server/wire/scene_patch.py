"""Changes of a scene's edits as JSON Merge Patch (RFC 7396): what is named changes, null takes an edit back."""

from typing import Any

from pydantic import ValidationError

from gpu.errors import UserError
from gpu.scene.edits import SceneEdits
from server.wire.browser import describe


def patched(edits: SceneEdits, patch: dict[str, Any]) -> SceneEdits:
    """`edits` after `patch`; UserError, which names the field, where they would not be sound."""
    try:
        made = SceneEdits.model_validate(_merged(edits.model_dump(exclude_none=True), patch))
    except ValidationError as error:
        raise UserError(describe(error)) from None
    kept = made.model_dump(exclude_none=True)
    return SceneEdits.model_validate(
        {kind: {one: edit for one, edit in parts.items() if edit} for kind, parts in kept.items()}
    )


def _merged(target: Any, patch: Any) -> Any:
    """RFC 7396, section 2."""
    if not isinstance(patch, dict):
        return patch
    made = dict(target) if isinstance(target, dict) else {}
    for name, value in patch.items():
        if value is None:
            made.pop(name, None)
        else:
            made[name] = _merged(made.get(name), value)
    return made
