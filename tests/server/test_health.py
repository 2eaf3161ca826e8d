from collections.abc import Callable

from harness import Running


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
