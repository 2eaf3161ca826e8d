"""Changes of a scene's edits as JSON Merge Patch (RFC 7396): what is named changes, null takes an edit back."""

from collections.abc import Mapping
from typing import TypeVar

from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits
from server.wire.browser import ScenePatch

PartEdit = TypeVar("PartEdit", LightEdit, MaterialEdit, ObjectEdit)


def patched(edits: SceneEdits, patch: ScenePatch) -> SceneEdits:
    """`edits` after `patch`; what then says nothing of a part is left out. What is not named is not looked at."""
    named = patch.model_fields_set
    return SceneEdits.model_construct(
        time=patch.time if "time" in named else edits.time,
        animation=patch.animation if "animation" in named else edits.animation,
        lights=_patched(edits.lights, patch.lights) if "lights" in named else edits.lights,
        materials=_patched(edits.materials, patch.materials) if "materials" in named else edits.materials,
        objects=_patched(edits.objects, patch.objects) if "objects" in named else edits.objects,
    )


def _patched(parts: Mapping[str, PartEdit], changes: Mapping[str, PartEdit | None] | None) -> dict[str, PartEdit]:
    """RFC 7396, section 2; the fields of a part are replaced as a whole."""
    made = {} if changes is None else dict(parts)
    for one, change in (changes or {}).items():
        said = change and (made.get(one) or type(change)()).model_copy(update=change.model_dump(exclude_unset=True))
        if said is None or said == type(said)():
            made.pop(one, None)
        else:
            made[one] = said
    return made
