"""The whole service with the real renderer, which breaks."""

import pytest
from devices import DEVICES
from harness import Running, run

from server.settings import ServerSettings
from tests.load.fault_worker import FAULT_WORKER, HANG_SEED, ILLEGAL_SEED

START_SECONDS = 280.0


@pytest.fixture(params=DEVICES)
def device(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def render(running: Running, seed: int = 0) -> int:
    """Of a quarter of the pixels where it is sound: what is like two that ended workers is refused."""
    body = {"size": [32, 18] if seed else [16, 9], "settings": {"seed": seed}}
    return running.http.post("/api/v1/render", json=body, timeout=60).status_code


def test_an_illegal_access_and_a_hang_end_only_the_worker(device: str) -> None:
    with run(ServerSettings(port=0, device=device, hang_seconds=8.0), FAULT_WORKER) as running:
        running.wait_ready(START_SECONDS)
        assert render(running) == 200
        for restarts, seed in enumerate((ILLEGAL_SEED, HANG_SEED), 1):
            assert render(running, seed) == 503
            assert running.http.get("/readyz").status_code == 503
            running.wait_ready(START_SECONDS)
            assert running.service.engines.restarts == restarts
            assert render(running) == 200
