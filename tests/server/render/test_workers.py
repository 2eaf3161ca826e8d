"""Workers are told what they serve as they are started; the first may be early."""

import sys
from collections.abc import Sequence

import pytest
from harness import GRADIENT_WORKER, alive, wait_for

from server.render.worker_process import WorkerProcess
from server.render.workers import Workers
from server.wire.worker import Progress, SceneRef, Start, read

START = Start(SceneRef("cornell-box", "cornell-box"))


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[WorkerProcess]:
    """The workers that were started."""
    processes = list[WorkerProcess]()

    def start(command: Sequence[str]) -> WorkerProcess:
        processes.append(WorkerProcess(command))
        return processes[-1]

    monkeypatch.setattr("server.render.workers.WorkerProcess", start)
    return processes


def heard(process: WorkerProcess) -> bool:
    """Whether a worker was told what it serves, which it answers."""
    with process.socket.makefile("rb") as pipe:
        return isinstance(read(pipe)[0], Progress)


def test_an_early_worker_is_the_first_and_has_been_told(started: list[WorkerProcess]) -> None:
    workers = Workers(GRADIENT_WORKER, START)
    with workers.early():
        assert heard(started[0])
        assert workers.new() is started[0]
        with workers.new() as other:
            assert heard(other)
            assert started == [started[0], other]
    assert not alive(started[0].pid)


def test_one_that_runs_already_is_the_early_one(started: list[WorkerProcess]) -> None:
    workers = Workers(GRADIENT_WORKER, START)
    with WorkerProcess(GRADIENT_WORKER) as first, workers.early(first):
        assert heard(first)
        assert workers.new() is first
    assert started == []


def test_one_that_has_ended_is_told_nothing() -> None:
    workers = Workers(GRADIENT_WORKER, START)
    with WorkerProcess((sys.executable, "-c", "")) as first:
        wait_for(lambda: first.status() is not None)
        with workers.early(first):
            assert workers.new() is first
