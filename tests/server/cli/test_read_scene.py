"""The process that reads a command's scene: what it answers, and that nothing else gets into the answer."""

import os
import pickle
import subprocess
from pathlib import Path

import pytest

from gpu.child_process import clean_environment, module_command
from gpu.scene.import_options import DEFAULT_OPTIONS
from gpu.scene.types import Scene
from server.cli import read_scene
from server.cli.read_scene import ReadRequest, read

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_the_answer_is_a_scene_or_a_sentence(tmp_path: Path) -> None:
    request = ReadRequest(source=str(tmp_path / "wall.obj"), options=DEFAULT_OPTIONS)
    command, printed = (*module_command("server.cli.read_scene"), str(os.getpid())), []
    for content in (TRIANGLE, "f 1 2 3\n"):
        (tmp_path / "wall.obj").write_text(content)
        text = request.model_dump_json().encode()
        done = subprocess.run(command, input=text, capture_output=True, check=True, env=clean_environment())
        printed.append(done.stdout)
    scene, sentence = map(pickle.loads, printed)
    assert isinstance(scene, Scene)
    assert scene.triangles.tolist() == [[0, 1, 2]]
    assert sentence == read(request)
    assert sentence.startswith(f"{request.source}: line 1: ")


@pytest.mark.parametrize("error", [MemoryError, RecursionError])
def test_too_little_memory_is_said(monkeypatch: pytest.MonkeyPatch, error: type[Exception]) -> None:
    def fail(*_: object, **__: object) -> Scene:
        raise error

    monkeypatch.setattr(read_scene, "load_scene", fail)
    request = ReadRequest(source="wall.obj", options=DEFAULT_OPTIONS)
    assert read(request) == "wall.obj: takes more memory to read than there is; simplify it"
