"""What a process can do behind the walls that this kernel has."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from server.scenes import landlock, seccomp, walls

ROOT = Path(__file__).parents[3]
# Tries each of its arguments, which are Python, behind the walls, and prints what happens: "done" or the error.
TRY = f"""
import os, signal, socket, subprocess, sys, threading
sys.path.append({str(ROOT)!r})
from pathlib import Path
from server.scenes import walls
folder, more, *tries = sys.argv[1:]
walls.open_only([Path(folder)])
walls.start_nothing(except_processes=more == "processes")
for each in tries:
    try:
        exec(each)
        print("done")
    except OSError as error:
        print(type(error).__name__)
"""
needs_landlock = pytest.mark.skipif(not landlock.version(), reason="this kernel has no Landlock")
needs_seccomp = pytest.mark.skipif(not seccomp.available(), reason="this kernel has no seccomp")


def tried(folder: Path, *tries: str, more: str = "") -> dict[str, str]:
    done = subprocess.run([sys.executable, "-I", "-c", TRY, str(folder), more, *tries], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return dict(zip(tries, done.stdout.split(), strict=True))


@needs_landlock
def test_only_the_scene_and_pythons_own_files_are_opened(tmp_path: Path) -> None:
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "a.gltf").write_text("{}")
    (folder / "link.bin").symlink_to(tmp_path / "secret")
    (tmp_path / "secret").write_text("secret")
    may = (f"open({str(folder / 'a.gltf')!r})", f"os.listdir({str(folder)!r})", "import wave, zlib", "import numpy")
    must_not = (
        f"open({str(folder / 'link.bin')!r})",
        f"open({str(tmp_path / 'secret')!r})",
        f"os.listdir({str(tmp_path)!r})",
        f"open({str(folder / 'new')!r}, 'w')",
        f"os.remove({str(folder / 'a.gltf')!r})",
        "open('/etc/passwd')",
        "open(f'/proc/{os.getppid()}/environ')",
    )
    assert tried(folder, *may, *must_not) == dict.fromkeys(may, "done") | dict.fromkeys(must_not, "PermissionError")


@needs_landlock
def test_packages_may_be_installed_anywhere(tmp_path: Path) -> None:
    """Of other folders on Python's path only the names are read."""
    folder, packages, project = tmp_path / "scene", tmp_path / "packages", tmp_path / "project"
    for each in (folder, packages, packages / "one-1.0.dist-info", project):
        each.mkdir()
    (packages / "one.py").touch()
    (project / "two.py").touch()
    path = f"sys.path += [{str(packages)!r}, {str(project)!r}]\n"
    run = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys\n{path}{TRY}", str(folder), "", "import one", "import two"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == ["done", "PermissionError"]


@needs_seccomp
def test_there_is_no_network_and_no_other_process(tmp_path: Path) -> None:
    may = ("threading.Thread(target=print, args=('',)).start()", "os.kill(os.getpid(), 0)")
    must_not = (
        "socket.socket()",
        "socket.socketpair()",
        "os.fork()",
        "subprocess.run(['/bin/true'])",
        "os.execv('/bin/true', ['true'])",
        "os.kill(os.getppid(), 0)",
    )
    assert tried(tmp_path, *may, *must_not) == dict.fromkeys(may, "done") | dict.fromkeys(must_not, "PermissionError")


@needs_seccomp
def test_processes_may_be_allowed_behind_the_same_walls(tmp_path: Path) -> None:
    child = "import socket; socket.socket()"
    started = f"assert subprocess.run([{sys.executable!r}, '-c', {child!r}], capture_output=True).returncode == 1"
    assert tried(tmp_path, started, "socket.socket()", more="processes") == {
        started: "done", "socket.socket()": "PermissionError"
    }  # fmt: skip


def test_without_walls_all_goes_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("platform.machine", lambda: "")
    assert walls.missing() == ["Landlock", "seccomp"]
    assert not walls.open_only([tmp_path])
    assert not walls.start_nothing()


def test_a_process_ends_with_the_one_that_started_it() -> None:
    waits = (
        "import os, time; from server.scenes import walls; walls.end_with_parent(os.getppid()); "
        "print('up', flush=True); time.sleep(60)"
    )
    starts = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {waits!r}]).wait()"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen([sys.executable, "-c", starts], stdout=subprocess.PIPE, env=environment) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"up\n"
        parent.kill()
        assert parent.stdout.read() == b""  # the child had it open too


def test_it_ends_where_that_one_has_ended_already(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walls, "process_control", lambda *_: 0)
    with pytest.raises(SystemExit):
        walls.end_with_parent(os.getppid() + 1)
