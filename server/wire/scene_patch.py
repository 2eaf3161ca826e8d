"""Changes of a scene's edits as JSON Merge Patch (RFC 7396): what is named changes, null takes an edit back."""

from typing import Any

from gpu.scene.edits import SceneEdits
from server.wire.browser import ScenePatch


def patched(edits: SceneEdits, patch: ScenePatch) -> SceneEdits:
    """`edits` after `patch`; what then says nothing of a light or a material is left out."""
    merged = _merged(edits.model_dump(exclude_none=True), patch.model_dump(exclude_unset=True))
    return SceneEdits.model_validate(
        {kind: {one: it for one, it in parts.items() if it} for kind, parts in merged.items()}
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
