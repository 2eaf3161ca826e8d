"""The fault checks against a service with gradients for pictures, with small numbers."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from gradient_worker import FAULT_SEED

from tests.load import breaks, uninvited
from tests.load.checks import quick
from tests.load.faults import CHECKS, check, service
from tests.load.probe import state
from tests.load.target import Target

WORKER = str(Path(__file__).parents[1] / "server" / "gradient_worker.py")
SCALE = quick(FAULT_SEED)
# What ends the service or its renderers, or leaves it too busy for others from the same address.
ALONE = [name for name, check in CHECKS.items() if check.__module__ in (breaks.__name__, uninvited.__name__)]
# What compares rates of frames, which a busy machine may change between two phases; a fault does so each time.
RATES, TRIES = ("slow-reader", "flood"), 3
GONE_SECONDS = 40.0  # until nobody of a check is there any more


@pytest.fixture(scope="module")
def runner() -> Iterator[asyncio.Runner]:
    with asyncio.Runner() as runner:
        yield runner


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("shared") / "server.log"


@pytest.fixture(scope="module")
def shared_target(runner: asyncio.Runner, log: Path) -> Iterator[Target]:
    """A service that goes through several checks: what one of them leaves behind must not trouble the next."""
    serving = service(SCALE, WORKER, log=log)
    target = runner.run(serving.__aenter__())
    try:
        yield target
    finally:
        runner.run(serving.__aexit__(None, None, None))


@pytest.mark.parametrize("name", ALONE)
def test_the_service_survives_alone(name: str, tmp_path: Path) -> None:
    log = tmp_path / "server.log"
    outcome = asyncio.run(check(name, SCALE, WORKER, log=log))
    assert not outcome.failures, (outcome, log.read_text())


@pytest.mark.parametrize("name", [name for name in CHECKS if name not in ALONE])
def test_the_service_survives(name: str, runner: asyncio.Runner, shared_target: Target, log: Path) -> None:
    async def gone() -> bool:
        async with shared_target.http() as http, asyncio.timeout(GONE_SECONDS):
            while (await state(http))["viewers"]:
                await asyncio.sleep(0.05)
        return True

    for _ in range(TRIES if name in RATES else 1):
        outcome = runner.run(CHECKS[name](shared_target, SCALE))
        assert runner.run(gone())
        if not outcome.failures:
            break
    assert not outcome.failures, (outcome, log.read_text())
