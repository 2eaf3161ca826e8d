"""On machines without a GPU: what would be compiled for one is noted."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import warp as wp

from gpu.child_process import module_command
from gpu.device_scene.upload import DeviceScene
from gpu.settings import RenderSettings
from server.worker import warm_ahead as module
from server.worker.warm_ahead import begin, warm_ahead

GPU: Any = SimpleNamespace(is_cuda=True, arch=90)
Run = tuple[int, tuple[str, ...], bool]


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Run]:
    """What is compiled, as (architecture, the scene's materials, whether generally), into a cache of the test's own."""
    found: list[Run] = []

    def note(architecture: int, scene: DeviceScene, settings: RenderSettings) -> None:
        assert settings == RenderSettings()
        found.append((architecture, tuple(material.name for material in scene.scene.materials), scene.general))

    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    monkeypatch.setattr(module, "warm_up_for", note)
    monkeypatch.setattr(module, "BUILTIN", {"cornell-box": None, "glass-box": None})
    return found


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """The commands of processes that are started."""
    commands: list[tuple[str, ...]] = []
    monkeypatch.setattr(module, "Popen", lambda command, **_: commands.append(command))
    return commands


def test_general_kernels_of_all_built_in_scenes_are_compiled_once(runs: list[Run]) -> None:
    warm_ahead(90)
    assert [(architecture, general) for architecture, _, general in runs] == [(90, True), (90, True)]
    assert runs[0][1] != runs[1][1]


def test_one_process_at_a_time_compiles(runs: list[Run], monkeypatch: pytest.MonkeyPatch) -> None:
    inner: Callable[..., None] = module.warm_up_for

    def meanwhile(*arguments: Any) -> None:
        inner(*arguments)
        warm_ahead(90)

    monkeypatch.setattr(module, "warm_up_for", meanwhile)
    warm_ahead(90)
    assert len(runs) == 2


def test_a_process_begins_for_a_gpu_until_all_is_there(runs: list[Run], started: list[tuple[str, ...]]) -> None:
    begin(GPU)
    assert started == [(*module_command("server.worker.warm_ahead"), str(os.getpid()), "90")]
    warm_ahead(90)
    begin(GPU)
    assert len(started) == 1
    begin(SimpleNamespace(is_cuda=True, arch=80))
    assert len(started) == 2


def test_on_a_cpu_frames_need_the_cores(runs: list[Run], started: list[tuple[str, ...]], cpu: str) -> None:
    assert begin(wp.get_device(cpu)) is None
    assert started == []


def test_a_process_whose_parent_is_gone_ends_at_once(tmp_path: Path) -> None:
    command = (*module_command("server.worker.warm_ahead"), "1", "90")
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path)}
    assert subprocess.run(command, env=environment, timeout=60, check=False).returncode == 0
    assert not list(tmp_path.iterdir())


def test_where_no_process_can_be_had_frames_go_on_without(runs: list[Run], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(module, "Popen", refuse)
    assert begin(GPU) is None
