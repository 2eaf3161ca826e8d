"""Results as JSON files: what was measured, on what, and with which options."""

import json
import os
import platform
import subprocess
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from gpu.errors import UserError
from tests.load import probe
from tests.load.target import Target


async def environment(target: Target) -> dict[str, str]:
    """What the figures were measured on; $COMMIT names the commit of a tree that came without git."""
    async with target.http() as http:
        state = await probe.state(http)
    describe = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    git = subprocess.run(describe, capture_output=True, text=True, check=False).stdout.strip()
    return {
        "device": str(state.get("device", "unknown")),
        "cores": str(os.cpu_count()),
        "python": platform.python_version(),
        "commit": os.environ.get("COMMIT") or git or "unknown",
    }


def save(folder: Path | None, name: str, results: Mapping[str, Any]) -> None:
    """Write FOLDER/NAME.json; nothing without a folder."""
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.json").write_text(json.dumps(_plain(results), indent=1, allow_nan=False) + "\n")


def load(folder: Path, name: str) -> dict[str, Any] | None:
    """What `save` wrote, None if it did not; UserError when the file is something else."""
    file = folder / f"{name}.json"
    if not file.is_file():
        return None
    try:
        results: dict[str, Any] = json.loads(file.read_text())
    except ValueError as error:
        raise UserError(f"{file}: is not a result of this harness: {error}") from None
    return results


def _plain(value: Any) -> Any:
    """`value` with None for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value
