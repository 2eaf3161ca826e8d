"""Which replica of a Ray Serve deployment a request goes to: by its path, /r/<replica>/…; newcomers by scene and load.

Ray's own consistent hashing goes by a header, of which a browser gives its WebSockets only the subprotocols, and its
other requests not even those; a path holds for the page and all that it asks for. docs/scale.md says more.
"""

import pickle
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from ray.serve.experimental.consistent_hash_router import ConsistentHashRouter

from server.cluster.own_path import named
from server.replicas import Answers, Roster

ANY_SCENE = ""  # of who does not say which


class PathRouter(ConsistentHashRouter):
    """Routes by path. From consistent hashing it has the loop that sends each request where `choose_replicas` says,
    where Ray's other loops give a replica to whatever request is next.
    """

    def initialize_state(self, **kwargs: Any) -> None:
        """Called once by Ray."""
        super().initialize_state(**kwargs)
        self._roster = Roster()
        self._heard: dict[str, tuple[float, Answers]] = {}  # by replica, with its own time of saying so

    def update_replicas(self, replicas: Sequence[Any]) -> None:
        """Called by Ray when replicas come, go, or say how they are (`Replica.record_routing_stats`)."""
        super().update_replicas(replicas)
        stats = {it.replica_id.unique_id: it.routing_stats for it in replicas if it.routing_stats.get("ready")}
        self._heard = {
            name: known if (known := self._heard.get(name)) and known[0] == said["at"] else (said["at"], _answers(said))
            for name, said in stats.items()
        }
        self._roster.hear({name: answers for name, (_, answers) in self._heard.items()})

    async def choose_replicas(self, candidate_replicas: Sequence[Any], pending_request: Any = None) -> list[list[Any]]:
        """Ranks of replicas, the first of which that takes the request gets it."""
        if pending_request is None or not candidate_replicas:
            return [list(candidate_replicas)]
        pending_request.routing_context.should_backoff = True
        by_name = {it.replica_id.unique_id: it for it in candidate_replicas}
        if (meant := _named(pending_request)) in by_name:
            return [[by_name[meant]]]
        ready = [name for name in by_name if name in self._roster.answers]
        if not ready:
            return [list(candidate_replicas)]
        chosen = self._roster.choose(pending_request.metadata.session_id or ANY_SCENE, ready)
        return [[by_name[chosen]], [it for name, it in by_name.items() if name != chosen]]


def _answers(stats: dict[str, Any]) -> Answers:
    loaded = dict.fromkeys((ANY_SCENE, *stats["loaded"]), True)
    return Answers(defaultdict(bool, loaded), stats["viewers"])


def _named(pending: Any) -> str | None:
    """The replica that a request from outside names in its path; None where it names none."""
    if not pending.metadata.is_http_request:
        return None
    prefix = named(pickle.loads(pending.args[0]).asgi_scope)  # what Ray's own proxy has packed
    return prefix[1] if prefix else None
