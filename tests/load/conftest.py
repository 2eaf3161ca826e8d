from collections.abc import Iterator

import pytest
from harness import Running, run

from server.settings import ServerSettings
from tests.load.target import Target


@pytest.fixture(scope="module")
def running() -> Iterator[Running]:
    """A ready service with gradients for pictures."""
    with run(ServerSettings(port=0, max_viewers=6)) as service:
        service.wait_ready()
        yield service


@pytest.fixture
def target(running: Running) -> Target:
    return Target(str(running.http.base_url).rstrip("/"))
