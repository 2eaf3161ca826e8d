import asyncio
import os
from dataclasses import replace
from pathlib import Path

import pytest

from gpu.errors import UserError
from gpu.scene.import_options import ImportOptions
from server.refusals import TooBusyError
from server.scenes import changed_files
from server.scenes.changed_files import ChangedFiles
from server.scenes.served import scene_ref
from server.scenes.versions import Versions
from server.wire.worker import SceneRef


def test_a_file_that_changed_is_told_once_it_stays_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(changed_files, "LOOK_SECONDS", 0.0)
    file, lost = tmp_path / "hall.glb", tmp_path / "lost.glb"
    file.touch()
    lost.touch()
    hall = scene_ref("hall.glb", str(file), ImportOptions(unit="mm"))
    scenes = [hall, scene_ref("lost.glb", str(lost), ImportOptions()), SceneRef("cornell-box", "cornell-box")]
    lost.unlink()
    looks, told = 0, list[tuple[int, SceneRef, SceneRef, UserError | None]]()
    error = UserError("hall.glb: is cut off")

    def viewed() -> list[SceneRef]:
        nonlocal looks
        looks += 1
        if looks in (2, 3, 7):  # at first it is still being written
            os.utime(file, ns=(1, looks))
        return scenes

    answers: list[Exception | None] = [TooBusyError("later"), error]

    async def read(_: SceneRef) -> None:
        if (answer := answers.pop(0) if answers else None) is not None:
            raise answer

    async def look() -> None:
        files = ChangedFiles(viewed, Versions(), read)
        files.listeners.add(lambda *change: told.append((looks, *change)))
        running = asyncio.create_task(files.run())
        while looks < 9:
            await asyncio.sleep(0.001)
        running.cancel()
        await asyncio.wait([running])

    asyncio.run(look())
    written = [replace(hall, stamp=stamp) for stamp in (3, 7)]
    assert told[:2] == [(5, hall, written[0], error), (8, hall, written[1], None)]  # at the fourth look it was too busy
