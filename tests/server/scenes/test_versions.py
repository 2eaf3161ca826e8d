import os
from pathlib import Path

import pytest

from gpu.scene.import_options import DEFAULT_OPTIONS
from server.refusals import UnknownSceneError
from server.scenes import versions
from server.scenes.versions import Versions
from server.wire.worker import SceneRef


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    for name, seconds in (("hall.gltf", 100), ("hall.bin", 90)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (seconds, seconds))
    return tmp_path / "hall.gltf"


def now(known: Versions, hall: Path) -> SceneRef:
    return known.now("hall.gltf", str(hall), DEFAULT_OPTIONS)


def test_a_scene_is_another_version_once_a_file_beside_it_changes_or_comes(hall: Path) -> None:
    known = Versions()
    first = now(known, hall)
    assert first == SceneRef("hall.gltf", str(hall), 100 * 10**9)
    known.learn(first, {"hall.bin": 90 * 10**9, "wood.png": 0})
    assert now(known, hall) == first
    os.utime(hall.with_name("hall.bin"), (80, 80))
    changed = now(known, hall)
    assert changed.stamp != first.stamp
    known.learn(changed, {"hall.bin": 80 * 10**9, "wood.png": 0, "more.png": 0})  # as it is opened anew
    assert now(known, hall) == changed
    hall.with_name("wood.png").touch()
    assert now(known, hall).stamp not in (first.stamp, changed.stamp)
    hall.with_name("wood.png").unlink()
    os.utime(hall.with_name("hall.bin"), (90, 90))
    assert now(known, hall) == first


def test_what_changed_while_a_scene_was_read_is_another_version(hall: Path) -> None:
    known = Versions()
    first = now(known, hall)
    known.learn(first, {"hall.bin": 80 * 10**9})
    assert now(known, hall) != first


def test_a_scene_whose_own_file_is_gone_is_unknown(hall: Path) -> None:
    known = Versions()
    known.learn(now(known, hall), {"hall.bin": 0})
    hall.unlink()
    with pytest.raises(UnknownSceneError):
        now(known, hall)


def test_few_scenes_are_remembered(hall: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(versions, "MOST", 1)
    known = Versions()
    known.learn(now(known, hall), {"hall.bin": 0})
    known.learn(SceneRef("b", "b"), {"b.bin": 0})
    assert now(known, hall).stamp == 100 * 10**9
