"""The fault checks against a service with gradients for pictures, with small numbers."""

import asyncio
from pathlib import Path

import pytest
from gradient_worker import FAULT_SEED

from tests.load.checks import quick
from tests.load.faults import CHECKS, check

WORKER = str(Path(__file__).parents[1] / "server" / "gradient_worker.py")


@pytest.mark.parametrize("name", CHECKS)
def test_the_service_survives(name: str, tmp_path: Path) -> None:
    log = tmp_path / "server.log"
    outcome = asyncio.run(check(name, quick(FAULT_SEED), WORKER, log=log))
    assert not outcome.failures, (outcome, log.read_text())
