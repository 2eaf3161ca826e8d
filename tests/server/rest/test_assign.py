import httpx
import pytest
from harness import Running, run

from server import replicas
from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}


def ask(service: Running, scene: str = "cornell-box") -> httpx.Response:
    return service.http.post("/api/v1/assign", json={"scene": scene}, headers=BEARER)


def test_a_viewer_is_sent_to_a_replica_that_can_render(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replicas, "ASK_SECONDS", 60.0)
    with run(ServerSettings(port=0, token=TOKEN, root_path="/r/a")) as replica:
        replica.wait_ready()
        urls = f"http://127.0.0.1:1/r/gone,{replica.http.base_url}/r/a".replace("//r", "/r")
        with run(ServerSettings(port=0, token=TOKEN, replicas=urls)) as service:
            assert ask(service).json() == {"url": "/r/a/"}
            assert ask(service, "none.glb").json()["code"] == "unknown-scene"
            assert ask(service, "").status_code == 422
            assert service.http.post("/api/v1/assign", json={"scene": "cornell-box"}).status_code == 401
            replica.service.stopping.set()
            assert service.service.replicas is not None
            service.service.replicas._known_until = -1.0
            refused = ask(service)
            assert (refused.status_code, refused.json()["code"]) == (503, "unavailable")
            assert "Retry-After" in refused.headers


def test_without_replicas_none_are_assigned(running: Running) -> None:
    refused = ask(running)
    assert (refused.status_code, refused.json()["code"]) == (403, "forbidden")
    assert "--replicas" in refused.json()["message"]


@pytest.mark.parametrize("urls", ["http://a/r/0,http://b/r/0", ",".join(f"http://a/r/{n}" for n in range(257))])
def test_replicas_need_prefixes_of_their_own_and_are_no_more_than_256(urls: str) -> None:
    with pytest.raises(ValueError, match=r"path prefix of its own|at most 256"):
        ServerSettings(replicas=urls)
