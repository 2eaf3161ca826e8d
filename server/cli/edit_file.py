"""What differs from a scene's file, as a JSON file of edits says."""

import json
from pathlib import Path

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, SceneEdits
from server.wire.scene_patch import patched


def read_edits(path: Path) -> SceneEdits:
    """The edits in the file `path`; raises UserError where it cannot be read, or names the field that is wrong."""
    try:
        found = json.loads(path.read_bytes())
    except OSError as error:
        raise UserError(f"--edit: {path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise UserError(f"--edit: {path}: is no JSON: {error}") from None
    if not isinstance(found, dict):
        raise UserError(f'--edit: {path}: is no JSON object, such as {{"lights": {{"lamp": {{"on": false}}}}}}')
    try:
        return patched(NO_EDITS, found)
    except UserError as error:
        raise UserError(f"--edit: {path}: {error}") from None
