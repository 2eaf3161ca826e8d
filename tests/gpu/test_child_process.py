"""Commands and environments of child processes: nothing of the current folder or of PYTHONPATH runs in them."""

import subprocess
from pathlib import Path

import pytest

from gpu.child_process import clean_environment, module_command

# Modules that a child might import by mistake: Python's own hooks, a library's, the standard library's, this project's.
NAMES = ("sitecustomize", "usercustomize", "numpy", "json", "runpy", "gpu", "ufbx")


@pytest.fixture
def trap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, in PYTHONPATH too, with modules that leave a file when they are run."""
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'a').write({name!r})")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", f":.:{tmp_path}")
    monkeypatch.setenv("PYTHONSTARTUP", str(tmp_path / "json.py"))
    return tmp_path / "ran"


@pytest.mark.parametrize("cleaned", [True, False])
def test_nothing_of_the_current_folder_or_of_pythonpath_runs(trap: Path, cleaned: bool) -> None:
    command = module_command("gpu.scene.formats.fbx.extract")
    environment = clean_environment() if cleaned else None
    done = subprocess.run(command, input=b"not FBX", capture_output=True, check=False, env=environment)
    assert done.returncode == 1
    assert not trap.exists()


def test_arguments_follow_the_module(tmp_path: Path) -> None:
    command = (*module_command("platform"), "--terse")
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path, env=clean_environment())
    assert len(done.stdout.splitlines()) == 1


def test_no_secrets_are_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    secrets = ("LUMENWALK_TOKEN", "AWS_SECRET_ACCESS_KEY", "PYTHONPATH", "LD_PRELOAD", "SSH_AUTH_SOCK")
    for name in secrets:
        monkeypatch.setenv(name, "x")
    for name in ("CUDA_VISIBLE_DEVICES", "WARP_CACHE_PATH", "LC_ALL"):
        monkeypatch.setenv(name, "y")
    cleaned = clean_environment()
    assert not cleaned.keys() & {*secrets}
    assert [name for name, it in sorted(cleaned.items()) if it == "y"] == [
        "CUDA_VISIBLE_DEVICES", "LC_ALL", "WARP_CACHE_PATH"
    ]  # fmt: skip
