"""What a process of its own read of an FBX file: arrays, and all else as it stands in JSON."""

import io
import json
import signal
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.child_process import clean_environment, module_command
from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles

_COMMAND = module_command("gpu.scene.formats.fbx.extract")


@dataclass(frozen=True)
class Extracted:
    """A file that was read. told: see gpu.scene.formats.fbx.extract; arrays: by name; remarks: for the report."""

    path: Path
    limits: SceneLimits
    told: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    remarks: Remarks = field(default_factory=Remarks)


def run_extract(path: Path, content: bytes, limits: SceneLimits) -> Extracted:
    """What is in the FBX file at `path`, which has `content`. Raises SceneError when it cannot be read."""
    ended = subprocess.run(_COMMAND, input=content, capture_output=True, check=False, env=clean_environment())
    if ended.returncode:
        code = ended.returncode
        why = signal.Signals(-code).name if code < 0 else ended.stderr.decode("utf-8", "replace").strip()[-200:]
        raise SceneError(str(path), "", f"not an FBX file that can be read: {why or 'it does not begin as one'}")
    with np.load(io.BytesIO(ended.stdout), allow_pickle=False) as arrays:
        read = dict(arrays)
    found = Extracted(path, limits, json.loads(read.pop("json").tobytes()), read)
    for key, sentence in (
        ("animated", "animations are not played; the scene is shown without them"),
        ("skinned", "skinned meshes are shown in their bind pose"),
        ("curves", "curves and NURBS surfaces are not shown"),
    ):
        if found.told[key]:
            found.remarks.add(sentence)
    return found


def matrix_of(columns: list[list[float]]) -> Doubles:
    """The 4×4 matrix that has these four columns of three numbers."""
    matrix = np.eye(4)
    matrix[:3] = np.array(columns).T
    return matrix
