"""Files read by a process of its own for the worker."""

import sys
from pathlib import Path
from subprocess import Popen
from typing import Any

import numpy as np
import pytest
from glb_file import TRIANGLE_GLB
from harness import alive, wait_for

from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.load import load_scene
from server.scenes.packed_scene import write_scene
from server.wire.worker import SceneRef, Start
from server.worker import scene_reading
from server.worker.scene_reading import read_beside
from server.worker.tasks import Tasks, Turn

START = Start(SceneRef("", ""))


def test_a_scene_is_read_while_others_have_the_device(tmp_path: Path) -> None:
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB)
    source = str(tmp_path / "hall.glb")
    tasks, turns, scenes = Tasks(turn_seconds=60.0), 0, []
    DEVICE_SHARING.begin(tasks)
    try:
        tasks.ask_back(1)
        turn = tasks.start(1, lambda: scenes.append(read_beside(SceneRef("hall.glb", source), START)))
        while turn is not Turn.ENDED:
            turns += turn is Turn.GIVEN_BACK
            tasks.ask_back(1)
            turn = tasks.resume(1)
    finally:
        DEVICE_SHARING.begin(None)
    assert turns > 1  # though a turn is long: it has nothing to do with it
    expected = load_scene(source)
    np.testing.assert_array_equal(scenes[0].vertices, expected.vertices)
    assert scenes[0].materials == expected.materials


def test_what_is_wrong_is_said_by_the_name_of_the_scene(tmp_path: Path) -> None:
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB[:-5])
    with pytest.raises(SceneError, match=r"^hall: ") as told:
        read_beside(SceneRef("hall", str(tmp_path / "hall.glb")), START)
    assert str(tmp_path) not in str(told.value)


@pytest.mark.parametrize(
    ("program", "seconds", "sentence"),
    [
        ("import os; os.abort()", 20.0, "its reader ended with SIGABRT"),
        ("import time; time.sleep(60)", 0.2, "takes more than 0.2 s to read"),
        ("""print('{"field": "f", "problem": "is broken"}')""", 20.0, "f: is broken"),
    ],
)
def test_readers_that_end_badly_are_no_fault_of_the_worker(
    program: str, seconds: float, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_reading, "CHECK", (sys.executable, "-I", "-c", f"input()\n{program}"))
    with pytest.raises(SceneError, match=f"^hall: .*{sentence}|^hall: {sentence}"):
        read_beside(SceneRef("hall", "/nowhere/hall.glb"), Start(SceneRef("", ""), check_seconds=seconds))


def test_limits_of_files_are_none_of_built_in_scenes() -> None:
    few = Start(SceneRef("", ""), scene_limits=SceneLimits(max_triangles=1), check_seconds=0.01)
    assert len(read_beside(SceneRef("box", "cornell-box"), few).triangles) > 1


def test_a_reader_that_has_ended_before_it_was_asked_is_no_fault_of_the_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    class Ended(Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            self.wait()

    monkeypatch.setattr(scene_reading, "CHECK", (sys.executable, "-c", "raise SystemExit(3)"))
    monkeypatch.setattr(scene_reading, "Popen", Ended)
    with pytest.raises(SceneError, match="its reader ended with status 3"):
        read_beside(SceneRef("hall", "/nowhere/hall.glb"), START)


def test_what_a_reader_has_started_ends_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "pid"
    script = f"import os, time\nif not os.fork(): open({str(file)!r}, 'w').write(str(os.getpid()))\ntime.sleep(3600)"
    monkeypatch.setattr(scene_reading, "CHECK", (sys.executable, "-c", script))
    with pytest.raises(SceneError, match="takes more than 1 s"):
        read_beside(SceneRef("hall", "/nowhere/hall.glb"), Start(SceneRef("", ""), check_seconds=1.0))
    pid = int(file.read_text())
    wait_for(lambda: not alive(pid))


def test_a_reader_that_leaves_no_scene_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = (Path(__file__).parents[1] / "any_check.py").read_text()
    monkeypatch.setattr(
        scene_reading, "CHECK", (sys.executable, "-c", f"import sys; sys.path[:0] = {sys.path}\n{sound}")
    )
    with pytest.raises(SceneError, match="left no scene"):
        read_beside(SceneRef("hall", "/nowhere/hall.glb"), START)


def test_what_was_read_already_is_not_read_again(tmp_path: Path) -> None:
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB)
    scene, source = load_scene(str(tmp_path / "hall.glb")), str(tmp_path / "hall.glb")
    with (tmp_path / "packed").open("wb") as file:
        write_scene(scene, file)
    (tmp_path / "hall.glb").write_bytes(b"")
    read = read_beside(SceneRef("hall", source), START, str(tmp_path / "packed"))
    np.testing.assert_array_equal(read.vertices, scene.vertices)
    with pytest.raises(SceneError, match=r"^hall: "):
        read_beside(SceneRef("hall", source), START, str(tmp_path / "gone"))
