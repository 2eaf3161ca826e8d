"""With Ray: a cluster of this machine, replicas with gradients for pictures."""

import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # Ray's own
    serve = pytest.importorskip("ray.serve", reason="lumenwalk[cluster] is not installed")

import httpx
import ray
from harness import GRADIENT_WORKER, Walker
from websockets.sync.client import connect

from gpu.errors import UserError
from server.cluster.deployment import application, build
from server.settings import ServerSettings

pytestmark = pytest.mark.filterwarnings("default")
ROOT = Path(__file__).parents[3]
TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
PORT = 8123


def deploy(replicas: int, storage: str) -> None:
    settings = ServerSettings(device="cpu", token=TOKEN, host="0.0.0.0")
    serve.run(application(settings, storage, replicas, replicas, GRADIENT_WORKER), name="lumenwalk", route_prefix="/")


@pytest.fixture(scope="module")
def storage(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("store")
    (folder / "hall.glb").write_bytes(b"")
    return f"file://{folder}"


@pytest.fixture(scope="module")
def client(storage: str) -> Iterator[httpx.Client]:
    """Of a service of two replicas."""
    environment = {"env_vars": {"PYTHONPATH": f"{ROOT}:{ROOT / 'tests' / 'server'}"}}
    ray.init("local", num_cpus=3, include_dashboard=False, object_store_memory=100_000_000, runtime_env=environment)
    try:
        serve.start(http_options={"port": PORT})
        deploy(2, storage)
        with httpx.Client(base_url=f"http://127.0.0.1:{PORT}", headers=BEARER, timeout=60) as http:
            yield http
    finally:
        serve.shutdown()
        ray.shutdown()


def paths(client: httpx.Client, count: int) -> list[str]:
    """Of as many replicas as that, as newcomers are sent to them."""
    found, deadline = set[str](), time.monotonic() + 60
    while len(found) < count:
        assert time.monotonic() < deadline, found
        found.add(client.post("/api/v1/assign", json={"scene": "cornell-box"}).json()["url"])
        time.sleep(0.05)
    return sorted(found)


def walk(walker: Walker, first: int, frames: int = 10) -> None:
    for number in range(first, first + frames):
        walker.pose(number)
        header, _ = walker.frame(30)
        walker.send("ack", frame=header.frame)


def socket(path: str) -> Any:
    url = f"ws://127.0.0.1:{PORT}{path}api/v1/stream"
    return connect(url, additional_headers=BEARER, max_size=2**26, compression=None)


def states() -> dict[str, int]:
    """How many replicas there are by what they do."""
    deployment = serve.status().applications["lumenwalk"].deployments["lumenwalk"]
    return dict(deployment.replica_states)


def viewers(client: httpx.Client, path: str) -> int:
    return int(client.get(f"{path}readyz").json()["viewers"])


def test_a_page_and_all_that_it_asks_for_stay_with_a_replica(client: httpx.Client) -> None:
    assert client.get("/", headers={"Authorization": ""}).status_code == 401
    assert client.get("/").headers["Location"] in paths(client, 2)
    for path in paths(client, 2):
        assert client.get(path).status_code == client.get(f"{path}main.js").status_code == 200
        job = client.post(f"{path}api/v1/jobs", json={"scene": "cornell-box", "size": [32, 18]}).json()
        assert job["url"].startswith(path)
        assert {client.get(job["url"]).status_code for _ in range(5)} == {200}
        with socket(path) as opened:
            walker = Walker(opened)
            walker.hello()
            walk(walker, 1)
            assert viewers(client, path) == 1
    unknown = client.post("/api/v1/assign", json={"scene": "none.glb"})
    assert unknown.json()["code"] == "unknown-scene"
    assert "hall.glb" in {it["id"] for it in client.get("/api/v1/scenes").json()}


def test_a_walk_goes_on_while_its_replica_is_drained(client: httpx.Client, storage: str) -> None:
    both = paths(client, 2)
    with socket(both[0]) as one, socket(both[1]) as two:
        walkers = Walker(one), Walker(two)
        for walker in walkers:
            walker.hello()
        newer = Thread(target=deploy, args=(1, storage))
        newer.start()
        while not states().get("STOPPING"):
            time.sleep(0.2)
        for first in range(1, 60, 10):
            for walker in walkers:
                walk(walker, first)
            time.sleep(1.0)
    newer.join(120)
    assert not newer.is_alive()
    with socket("/r/gone/") as opened:  # as a page does that comes back
        walker = Walker(opened)
        walker.hello()
        walk(walker, 1)


def test_a_service_that_others_reach_needs_a_token_and_no_device_is_chosen() -> None:
    with pytest.raises(UserError, match="token"):
        build({"device": "cpu"})
    with pytest.raises(UserError, match="device"):
        build({"device": "cuda:1", "token": TOKEN})
    built = build({"device": "cpu", "token": TOKEN, "min_replicas": "2", "max_replicas": "5", "storage": "memory://x"})
    assert built is not None
