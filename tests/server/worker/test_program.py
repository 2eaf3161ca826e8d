"""What the worker's program does before it renders."""

import subprocess
import sys
from pathlib import Path

import pytest
from glb_file import TRIANGLE_GLB

from server.wire.worker import SceneRef, Start
from server.worker.program import backend_for
from server.worker.tasks import Tasks

ORDER = """
import sys
from server.wire.worker import SceneRef, Start
from server.worker import program

class Noted:
    def __init__(self, ref, start):
        print(ref.source, "warp" in sys.modules)

program.SceneReading = Noted
program.backend_for(Start(SceneRef("hall.glb", "/scenes/hall.glb")))
program.backend_for(Start(SceneRef("box", "cornell-box")))
print("warp" in sys.modules)
"""


def test_a_scene_is_read_while_what_renders_is_imported() -> None:
    run = subprocess.run([sys.executable, "-c", ORDER], capture_output=True, text=True, check=True)
    assert run.stdout == "/scenes/hall.glb False\nTrue\n"


def test_a_worker_begins_with_the_scene_that_is_being_read(
    cpu: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB)
    start = Start(SceneRef("hall.glb", str(tmp_path / "hall.glb")), cpu)
    backend = backend_for(start)
    monkeypatch.setattr("server.worker.backend.load_kept_kernels", lambda device: None)
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda device_scene, settings: None)
    monkeypatch.setattr("server.worker.backend.read_beside", lambda *_: pytest.fail("it is read again"))
    with monkeypatch.context() as started:
        started.setattr(backend, "render", lambda job, report: None)  # its first picture
        backend.start(start, lambda text, fraction: None, Tasks())
    assert backend.open(start.scene, lambda text, fraction: None).triangles == 1
