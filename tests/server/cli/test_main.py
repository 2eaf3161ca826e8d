"""The command's errors, and the worker that it starts before all else."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from harness import PATIENCE, alive

from server.cli import main as program
from server.render.worker_process import WorkerProcess

STUBBORN = (sys.executable, "-c", "import time; time.sleep(3600)")


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The ids of workers that were started, each of which does nothing."""
    pids = list[int]()

    def start(_: Sequence[str]) -> WorkerProcess:
        process = WorkerProcess(STUBBORN)
        pids.append(process.pid)
        return process

    monkeypatch.setattr(program, "WorkerProcess", start)
    return pids


def test_a_service_gets_the_worker_that_was_started_first(started: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    got = list[int]()

    def serve(_: object, *, first: WorkerProcess) -> None:
        assert alive(first.pid)
        got.append(first.pid)

    monkeypatch.setattr("server.serve.serve", serve)
    assert program.main(["serve", "--port", "0"]) == 0
    assert got == started
    assert not alive(started[0])


def test_no_worker_is_left_after_a_mistake(started: list[int], capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["serve", "--port", "one"]) == 2
    assert capsys.readouterr().err.startswith("lumenwalk: error: ")
    assert len(started) == 1
    assert not alive(started[0])


def test_a_service_that_is_ended_while_it_starts_leaves_nothing(tmp_path: Path) -> None:
    code = f"""
import time
from server.cli import main as program
program.WORKER = {STUBBORN!r}
program._run = lambda _, worker: (print(worker.pid, flush=True), time.sleep(3600))
program.main(["serve"])
"""
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        worker = int(process.stdout.readline())
        assert alive(worker)
        assert list(tmp_path.iterdir())
        process.terminate()
        assert process.wait(PATIENCE) == -signal.SIGTERM
    assert not alive(worker)
    assert not list(tmp_path.iterdir())


def test_who_wants_help_or_another_command_gets_no_worker(
    started: list[int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        program.main(["serve", "--help"])
    assert program.main(["info", str(tmp_path / "gone.glb")]) == 2
    assert "gone.glb" in capsys.readouterr().err
    assert started == []
