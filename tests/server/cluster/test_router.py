import asyncio
import pickle
import warnings
from types import SimpleNamespace
from typing import Any

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # Ray's own
    pytest.importorskip("ray.serve", reason="lumenwalk[cluster] is not installed")

from ray.serve._private.common import StreamingHTTPRequest

from server.cluster.router import PathRouter


def replica(name: str, **stats: Any) -> SimpleNamespace:
    said = {"at": 1.0, "ready": True, "loaded": [], "viewers": 0} | stats
    return SimpleNamespace(replica_id=SimpleNamespace(unique_id=name), routing_stats=said)


def request(path: str | None = None, scene: str = "") -> SimpleNamespace:
    """From outside, or by a handle."""
    scope = {"type": "http", "path": path}
    args = [] if path is None else [pickle.dumps(StreamingHTTPRequest(scope, proxy_actor_name="proxy"))]
    metadata = SimpleNamespace(is_http_request=path is not None, session_id=scene)
    return SimpleNamespace(args=args, metadata=metadata, routing_context=SimpleNamespace(should_backoff=False))


class Routing:
    """A router that has heard of replicas, without Ray around it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *replicas: SimpleNamespace) -> None:
        base = PathRouter.__mro__[1]
        monkeypatch.setattr(base, "initialize_state", lambda self, **kwargs: None)
        monkeypatch.setattr(base, "update_replicas", lambda self, replicas: None)
        self.router = PathRouter.__new__(PathRouter)
        self.router.initialize_state()
        self.hear(*replicas)

    def hear(self, *replicas: SimpleNamespace) -> None:
        self.replicas = list(replicas)
        self.router.update_replicas(self.replicas)

    def first(self, asked: SimpleNamespace) -> list[str]:
        ranks = asyncio.run(self.router.choose_replicas(candidate_replicas=self.replicas, pending_request=asked))
        return [it.replica_id.unique_id for it in ranks[0]]


def test_a_path_leads_to_the_replica_that_it_names(monkeypatch: pytest.MonkeyPatch) -> None:
    routing = Routing(monkeypatch, replica("one", viewers=9), replica("two"))
    for name in ("one", "two"):
        assert routing.first(request(f"/r/{name}/api/v1/stream")) == [name]
    assert routing.first(request("/r/gone/api/v1/stream")) == ["two"]
    assert routing.first(request("/api/v1/stream")) == ["two"]


def test_who_comes_goes_where_the_scene_is_then_where_fewest_are(monkeypatch: pytest.MonkeyPatch) -> None:
    routing = Routing(monkeypatch, replica("one", loaded=["hall"], viewers=3), replica("two"))
    assert routing.first(request(scene="hall")) == ["one"]
    assert routing.first(request(scene="attic")) == ["two"]
    assert routing.first(request(scene="cellar")) == ["one"]  # the other one loads the attic


def test_those_who_come_at_once_are_counted_until_a_replica_says_how_many_are_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routing = Routing(monkeypatch, replica("one"), replica("two", viewers=1))
    assert [routing.first(request("/"))[0] for _ in range(3)] == ["one", "one", "two"]
    routing.hear(replica("one"), replica("two", viewers=1, at=2.0))  # the first one has said nothing new
    assert routing.first(request("/")) == ["two"]
    routing.hear(replica("one", at=2.0), replica("two", viewers=1, at=3.0))
    assert routing.first(request("/")) == ["one"]


def test_newcomers_wait_for_no_replica_that_cannot_render_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    routing = Routing(monkeypatch, replica("one", ready=False), replica("two", viewers=20))
    assert routing.first(request("/")) == ["two"]
    routing.hear(replica("one", ready=False), SimpleNamespace(**vars(replica("two")) | {"routing_stats": {}}))
    assert routing.first(request("/")) == ["one", "two"]
