"""What differs from a scene's file, as a JSON file of edits says."""

from pathlib import Path

from pydantic import ValidationError

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, SceneEdits
from gpu.scene.formats.text import without_mark
from server.wire.browser import ScenePatch, describe
from server.wire.scene_patch import patched


def read_edits(path: Path) -> SceneEdits:
    """The edits in the file `path`; raises UserError where it cannot be read, or names the field that is wrong."""
    try:
        return patched(NO_EDITS, ScenePatch.model_validate_json(without_mark(path.read_bytes())))
    except OSError as error:
        raise UserError(f"--edit: {path}: cannot be read: {error.strerror}") from None
    except ValidationError as error:
        raise UserError(f"--edit: {path}: {describe(error)}") from None
