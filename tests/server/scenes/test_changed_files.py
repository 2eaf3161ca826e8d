import asyncio
import os
from pathlib import Path

import pytest

from gpu.scene.import_options import ImportOptions
from server.scenes import changed_files
from server.scenes.changed_files import ChangedFiles
from server.scenes.served import scene_ref
from server.wire.worker import SceneRef


def test_a_file_that_changed_is_told_once_it_stays_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(changed_files, "LOOK_SECONDS", 0.0)
    file, lost = tmp_path / "hall.glb", tmp_path / "lost.glb"
    file.touch()
    lost.touch()
    hall = scene_ref("hall.glb", str(file), ImportOptions(unit="mm"))
    scenes = [hall, scene_ref("lost.glb", str(lost), ImportOptions()), SceneRef("cornell-box", "cornell-box")]
    lost.unlink()
    looks, told = 0, list[tuple[int, SceneRef, SceneRef]]()

    def viewed() -> list[SceneRef]:
        nonlocal looks
        looks += 1
        if looks in (2, 3):  # it is still being written
            os.utime(file, ns=(1, looks))
        return scenes

    async def look() -> None:
        files = ChangedFiles(viewed)
        files.listeners.add(lambda old, new: told.append((looks, old, new)))
        running = asyncio.create_task(files.run())
        while looks < 5:
            await asyncio.sleep(0.001)
        running.cancel()
        await asyncio.wait([running])

    asyncio.run(look())
    newest = scene_ref("hall.glb", str(file), ImportOptions(unit="mm"))
    assert newest.stamp == 3
    assert told[0] == (4, hall, newest)
