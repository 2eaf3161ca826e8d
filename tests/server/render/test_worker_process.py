"""A worker's process: how it is started, what it gets, and how it ends where nobody speaks to it."""

import asyncio
import os
import sys
import tempfile
from pathlib import Path

import pytest
from harness import GRADIENT_WORKER, PATIENCE, alive

from gpu.errors import UserError
from server.render.worker_process import WorkerProcess, Workers
from server.wire.worker import Progress, SceneRef, Start, read

START = Start(SceneRef("cornell-box", "cornell-box"))
STUBBORN = (sys.executable, "-c", "import time; time.sleep(3600)")

# Threads, each of which has had 16 MB; ends with the number of MB that the process has more since.
THREADS = """
import ctypes, os, sys
from threading import Barrier, Thread
import numpy as np

def megabytes():
    return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGE_SIZE") >> 20

def work():
    all_here.wait()
    np.ones(2 << 20)
    all_here.wait()

np.ones(4 << 20)  # from now on glibc takes less than this from its heaps
all_here, before = Barrier(4), megabytes()
threads = [Thread(target=work) for _ in range(4)]
for step in (Thread.start, Thread.join):
    for thread in threads:
        step(thread)
ctypes.CDLL(None).malloc_trim(0)
sys.exit(max(megabytes() - before, 0))
"""


def status_of(*command: str) -> int:
    """How a program ends that is started as a worker."""

    async def main() -> int:
        process = WorkerProcess((sys.executable, "-c", *command), START)
        with process.socket:
            return await asyncio.wait_for(process.ended(), PATIENCE)

    return asyncio.run(main())


def test_a_worker_is_told_what_it_serves_as_it_starts() -> None:
    process = WorkerProcess(GRADIENT_WORKER, START)
    with process.socket.makefile("rb") as pipe:
        message, _ = read(pipe)
    process.end()
    assert isinstance(message, Progress)
    assert not alive(process.pid)


def test_a_command_that_does_not_exist_is_the_users_fault() -> None:
    with pytest.raises(UserError, match="cannot be started"):
        WorkerProcess(("/nowhere/python",), START)


def test_a_worker_gets_no_secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUMENWALK_TOKEN", "x" * 16)
    assert status_of(f"import os; open({str(tmp_path / 'names')!r}, 'w').write(str([*os.environ]))") == 0
    assert "PATH" in (tmp_path / "names").read_text()
    assert "TOKEN" not in (tmp_path / "names").read_text()


def test_a_worker_gives_back_what_its_threads_had() -> None:
    assert 0 <= status_of(THREADS) < 8


def test_an_early_worker_is_the_first_and_ends_where_nobody_takes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    started = list[WorkerProcess]()

    class Noted(WorkerProcess):
        def __init__(self, *how: object) -> None:
            super().__init__(*how)  # type: ignore[arg-type]
            started.append(self)

    monkeypatch.setattr("server.render.worker_process.WorkerProcess", Noted)
    workers = Workers(STUBBORN, START)
    with workers.early():
        pass
    assert not alive(started[0].pid)
    with workers.early():
        taken = workers.new()
    assert alive(taken.pid)
    other = workers.new()
    assert started[1:] == [taken, other]
    for process in (taken, other):
        process.end()
        with pytest.raises(ProcessLookupError):
            os.kill(process.pid, 0)  # not even its exit status is left
    assert list(tmp_path.iterdir()) == []
