"""In which order stages are run and forked, and what they launch."""

from collections.abc import Callable
from typing import Any

import pytest
import warp as wp

from gpu.core import device
from gpu.core.stages import Stages

Launched = dict[tuple[Any, ...], list[list[str]]]


def noted_stages(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of all stages from now on, `NAME waits` where they wait for forks, and of forks, `NAME PART`."""
    begun: list[str] = []
    fork, run = Stages.fork, Stages.run

    def noted_fork(stages: Stages, name: str, part: str, work: Callable[[], None], **how: Any) -> None:
        begun.append(f"{name} {part}")
        fork(stages, name, part, work, **how)

    def noted_run(stages: Stages, name: str, work: Callable[[], None], **how: Any) -> None:
        begun.append(f"{name} waits" if how.get("waits_for_fork") else name)
        run(stages, name, work, **how)

    monkeypatch.setattr(Stages, "fork", noted_fork)
    monkeypatch.setattr(Stages, "run", noted_run)
    return begun


def repeated_launches(monkeypatch: pytest.MonkeyPatch) -> Launched:
    """Kernels that stages which repeat launch from now on, each time that one runs, by name, branch and graph key."""
    found: Launched = {}
    noting: list[list[str]] = []
    run, is_noted = Stages.run, device.is_noted

    def noted_launch(kernel: wp.Kernel) -> bool:
        for kernels in noting:
            kernels.append(kernel.key)
        return is_noted(kernel)

    def noted_run(stages: Stages, name: str, work: Callable[[], None], *, repeats: bool = True, **how: Any) -> None:
        def noted() -> None:
            noting.append([])
            work()
            found.setdefault((name, how.get("branch"), stages.graph_key), []).append(noting.pop())

        run(stages, name, noted if repeats else work, repeats=repeats, **how)

    monkeypatch.setattr(device, "is_noted", noted_launch)
    monkeypatch.setattr(Stages, "run", noted_run)
    return found
