from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from harness import Running, Walker, run

from server.settings import ServerSettings


@pytest.fixture
def serve() -> Iterator[Callable[..., Running]]:
    """Starts services with the settings given; they end with the test."""
    with ExitStack() as stack:

        def start(ready: bool = True, **settings: Any) -> Running:
            running = stack.enter_context(run(ServerSettings(port=0, **settings)))
            if ready:
                running.wait_ready()
            return running

        yield start


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """One ready service for a module's tests, with a folder of two scenes, one of them broken."""
    folder = tmp_path_factory.mktemp("scenes")
    (folder / "rooms").mkdir()
    (folder / "rooms" / "hall.glb").write_bytes(b"")
    (folder / "broken.glb").write_bytes(b"")
    settings = ServerSettings(port=0, scenes_dir=folder, max_viewers=4, max_samples=64, max_stream_pixels=640 * 360)
    with run(settings) as service:
        service.wait_ready()
        yield service


@pytest.fixture
def visit() -> Iterator[Callable[[Running], Walker]]:
    """Sends viewers to a service; they leave with the test."""
    with ExitStack() as stack:
        yield lambda running: stack.enter_context(running.walker())
