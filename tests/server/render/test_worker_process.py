"""A worker's process: how it is started, what it gets, and how it ends where nobody speaks to it."""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from harness import GRADIENT_WORKER, alive, wait_for

from gpu.errors import UserError
from server.render.worker_process import WorkerProcess
from server.wire.worker import Progress, SceneRef, Start, pack, read

START = Start(SceneRef("cornell-box", "cornell-box"))

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


def status_of(program: str) -> int:
    """How a program ends that is started as a worker."""
    with WorkerProcess((sys.executable, "-c", program)) as process:
        wait_for(lambda: process.status() is not None)
        status = process.status()
    assert status is not None
    return status


def test_a_worker_has_the_other_end_of_the_socket() -> None:
    with WorkerProcess(GRADIENT_WORKER) as process:
        process.socket.sendall(pack(START))
        with process.socket.makefile("rb") as pipe:
            message, _ = read(pipe)
        assert process.status() is None
    assert isinstance(message, Progress)
    assert not alive(process.pid)


def test_nothing_is_left_of_one_that_does_not_end_by_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with WorkerProcess((sys.executable, "-c", "import time; time.sleep(3600)")) as process:
        assert len(list(tmp_path.iterdir())) == 1
    assert process.status() == -signal.SIGKILL
    assert list(tmp_path.iterdir()) == []


def test_it_is_there_before_what_serves_could_be() -> None:
    """What `lumenwalk serve` imports before it starts a worker."""
    program = "import sys, server.render.worker_process as it; print(*{name.split('.')[0] for name in sys.modules})"
    imported = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"asyncio", "numpy", "pydantic", "fastapi", "uvicorn"} & {*imported}


def test_a_command_that_does_not_exist_is_the_users_fault() -> None:
    with pytest.raises(UserError, match="cannot be started"):
        WorkerProcess(("/nowhere/python",))


def test_a_worker_gets_no_secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUMENWALK_TOKEN", "x" * 16)
    assert status_of(f"import os; open({str(tmp_path / 'names')!r}, 'w').write(str([*os.environ]))") == 0
    assert "PATH" in (tmp_path / "names").read_text()
    assert "TOKEN" not in (tmp_path / "names").read_text()


def test_a_worker_gives_back_what_its_threads_had() -> None:
    assert 0 <= status_of(THREADS) < 8
