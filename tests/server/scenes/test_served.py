"""The scene that a service begins with."""

from pathlib import Path

import pytest

from gpu.errors import UserError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from server.refusals import UnknownSceneError
from server.scenes.served import scene_ref, served_scene
from server.wire.worker import SceneRef


def test_a_file_is_known_by_its_name_and_time(tmp_path: Path) -> None:
    file, inches = tmp_path / "hall.glb", ImportOptions(unit="in")
    file.write_bytes(b"")
    assert served_scene(str(file), inches) == SceneRef("hall.glb", str(file), file.stat().st_mtime_ns, inches)


def test_a_built_in_scene_is_known_by_its_name() -> None:
    assert served_scene("atrium", DEFAULT_OPTIONS) == SceneRef("atrium", "atrium")


def test_a_scene_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"gone\.glb: there is no such file"):
        served_scene(str(tmp_path / "gone.glb"), DEFAULT_OPTIONS)
    with pytest.raises(UnknownSceneError, match="cannot be read"):
        scene_ref("gone.glb", str(tmp_path / "gone.glb"), DEFAULT_OPTIONS)
