"""In which order stages are run and forked."""

from collections.abc import Callable
from typing import Any

import pytest

from gpu.core.stages import Stages


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
