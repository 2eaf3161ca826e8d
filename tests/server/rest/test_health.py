import os
import signal
import time
from collections.abc import Callable

import pytest
from gradient_worker import FAULT_SEED, HANG_SEED
from harness import PATIENCE, Running, wait_for

from server.render.engine import Engine


def test_alive_is_not_yet_ready(serve: Callable[..., Running]) -> None:
    running = serve(ready=False)
    assert running.http.get("/healthz").json() == {"status": "ok"}
    response = running.http.get("/readyz")
    assert response.status_code == 503
    assert response.json()["status"] == "starting"
    assert response.json()["text"]
    assert "Retry-After" in response.headers


def test_ready_names_the_device(running: Running) -> None:
    response = running.http.get("/readyz")
    assert response.status_code == 200
    assert response.json()["device"] == "gradient"


def wait_unready(running: Running) -> None:
    deadline = time.monotonic() + PATIENCE
    while (response := running.http.get("/readyz")).status_code == 200:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert response.status_code == 503
    assert response.json()["status"] == "recovering"
    assert int(response.headers["Retry-After"]) > 0


@pytest.mark.parametrize("seed", [FAULT_SEED, HANG_SEED])
def test_a_render_that_breaks_the_renderer_makes_it_unready_for_a_moment(
    serve: Callable[..., Running], seed: int
) -> None:
    running = serve(hang_seconds=1.0)
    lost = running.http.post("/api/v1/render", json={"size": [8, 8], "settings": {"seed": seed}})
    assert lost.status_code == 503
    assert "Retry-After" in lost.headers
    running.service.engines.engines[0]._jobs.hang_seconds = PATIENCE
    wait_unready(running)
    running.wait_ready()
    assert running.http.get("/readyz").json()["restarts"] == 1
    assert running.http.post("/api/v1/render", json={"size": [8, 8]}).status_code == 200


def test_a_dead_renderer_is_no_ready_one(serve: Callable[..., Running]) -> None:
    running = serve()
    pid = running.service.engines.engines[0].worker_pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    wait_unready(running)
    assert running.http.get("/healthz").status_code == 200
    running.wait_ready()


def test_a_service_that_stops_is_not_ready(serve: Callable[..., Running]) -> None:
    running = serve()
    running.service.stopping.set()
    response = running.http.get("/readyz")
    assert response.status_code == 503
    assert response.json()["status"] == "stopping"


def test_a_service_whose_turn_takes_too_long_is_busy(
    serve: Callable[..., Running], monkeypatch: pytest.MonkeyPatch
) -> None:
    running = serve()
    monkeypatch.setattr(Engine, "overdue", "one job has had the renderer for 31 s")
    response = running.http.get("/readyz")
    assert response.status_code == 503
    assert (response.json()["status"], response.json()["text"]) == ("busy", "one job has had the renderer for 31 s")
    assert int(response.headers["Retry-After"]) > 0
    assert running.http.get("/healthz").status_code == 200


def test_one_worker_is_enough_and_each_is_told_of(serve: Callable[..., Running]) -> None:
    running = serve(device="cpu,cpu")
    engines = running.service.engines
    wait_for(lambda: all(engine.ready for engine in engines.engines))
    with running.walker() as walker:
        walker.hello()
        walker.pose(1)
        walker.frame()
        own = next(engine for engine in engines.engines if engines.clients_of(engine))
        assert own.worker_pid is not None
        os.kill(own.worker_pid, signal.SIGKILL)
        wait_for(lambda: not own.ready)
        response = running.http.get("/readyz")
        assert response.status_code == 200
        walker.pose(2)
        walker.frame()
        workers = running.http.get("/readyz").json()["workers"]
        assert sorted(worker["viewers"] for worker in workers) == [0, 1]
        assert workers[engines.engines.index(own)]["viewers"] == 0
    wait_for(lambda: own.ready)
    workers = running.http.get("/readyz").json()["workers"]
    assert [worker["status"] for worker in workers] == ["ready", "ready"]
    assert sorted(worker["restarts"] for worker in workers) == [0, 1]
    assert {worker["device"] for worker in workers} == {"gradient"}


def test_a_device_that_cannot_be_used_fails_the_service(serve: Callable[..., Running]) -> None:
    running = serve(ready=False, device="cpu,none")
    wait_for(lambda: running.http.get("/readyz").json()["status"] == "failed")
    assert running.http.get("/readyz").json()["text"] == "no device 'none' here"
