"""The other services that this one hands out addresses of: which answer, what they hold, who gets a newcomer."""

import asyncio
import ssl
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import monotonic

import httpx
from pydantic import BaseModel, TypeAdapter, ValidationError

from server.addresses import replica_prefix
from server.refusals import UnknownSceneError
from server.render.activity import EngineState
from server.render.placement import Candidate, choose, still_loading
from server.render.worker_link import WorkerLostError

KNOWN_SECONDS = 1.0  # that an answer counts
ASK_SECONDS = 1.0  # that a replica has for its answers, however slowly they drip
MAX_ANSWER_BYTES = 8 * 2**20  # of 10,000 scenes


class _Worker(BaseModel):
    status: str


class _Readiness(BaseModel):
    viewers: int
    workers: list[_Worker]


class _Scene(BaseModel):
    id: str
    loaded: bool


_scenes = TypeAdapter(list[_Scene])


@dataclass(frozen=True)
class Answers:
    """What a replica said last: its scenes, whether each is on a device, and viewers for each device."""

    scenes: Mapping[str, bool]
    viewers: int
    workers: int = 1


@dataclass
class _Sent:
    """What a replica was sent: newcomers since it was heard, and scenes that it has to load, with the time of each."""

    viewers: int = 0
    loading: dict[str, float] = field(default_factory=dict)


class Roster:
    """What is known of replicas that can render, by their names; no I/O here."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self.answers: Mapping[str, Answers] = {}
        self._sent: dict[str, _Sent] = {}
        self._now = now

    def hear(self, answers: Mapping[str, Answers]) -> None:
        """Of all that can render now; newcomers that were sent to one count until it says something new."""
        for name, said in answers.items():
            if said is self.answers.get(name):
                continue
            sent = self._sent.get(name, _Sent())
            there = [scene for scene, loaded in said.scenes.items() if loaded]
            self._sent[name] = _Sent(loading=still_loading(sent.loading, there, self._now()))
        self.answers = answers

    def choose(self, scene: str, names: Sequence[str]) -> str:
        """Of `names`, that for one more viewer of a scene: where it is on a device, then where fewest viewers are. One
        that loads another scene is spared where there is one that does not.
        """
        name = names[choose([self._candidate(name, scene) for name in names])]
        self._sent[name].viewers += 1
        if not self.answers[name].scenes[scene]:
            self._sent[name].loading.setdefault(scene, self._now())
        return name

    def _candidate(self, name: str, scene: str) -> Candidate:
        answers, sent = self.answers[name], self._sent[name]
        clients = round((answers.viewers + sent.viewers) / answers.workers)
        holds = answers.scenes[scene] or scene in sent.loading
        return Candidate(EngineState.READY, holds, has_room=True, loads=bool(sent.loading), clients=clients, busy=0.0)


class Replicas:
    """Asks the replicas of the settings, and nobody else, about once a second while somebody wants an address."""

    def __init__(self, urls: Sequence[str], token: str | None, now: Callable[[], float] = monotonic) -> None:
        """urls: as `check_replica` writes them; token: of all of them."""
        self._urls, self._now = urls, now
        self._headers = {"Accept-Encoding": "identity"} | ({"Authorization": f"Bearer {token}"} if token else {})
        self._tls = ssl.create_default_context()
        self._lock = asyncio.Lock()
        self._roster = Roster(now)
        self._known_until = -1.0

    async def choose(self, scene: str) -> str:
        """The path prefix of a replica for a viewer of a scene, as `Roster.choose` has it.

        Raises WorkerLostError where none can render, UnknownSceneError where those that can have no such scene.
        """
        async with self._lock:
            if self._now() >= self._known_until:
                await self._ask_all()
        answers = self._roster.answers
        if not answers:
            raise WorkerLostError(f"none of the {len(self._urls)} replicas can render now; try again later")
        fit = [url for url in answers if scene in answers[url].scenes]
        if not fit:
            raise UnknownSceneError(f"scene: there is no {scene!r} at any replica that can render now")
        return replica_prefix(self._roster.choose(scene, fit))

    async def _ask_all(self) -> None:
        # trust_env: neither proxies nor passwords of the environment are used.
        limits = httpx.Limits(max_connections=len(self._urls))
        async with httpx.AsyncClient(
            headers=self._headers, verify=self._tls, limits=limits, trust_env=False, follow_redirects=False
        ) as client:
            found = await asyncio.gather(*(self._ask(client, url) for url in self._urls))
        self._roster.hear({url: said for url, said in zip(self._urls, found, strict=True) if said is not None})
        self._known_until = self._now() + KNOWN_SECONDS

    async def _ask(self, client: httpx.AsyncClient, url: str) -> Answers | None:
        """What a replica says; None where it cannot render, or does not answer as it should."""
        try:
            async with asyncio.timeout(ASK_SECONDS):
                readiness = _Readiness.model_validate_json(await _read(client, f"{url}/readyz"))
                scenes = _scenes.validate_json(await _read(client, f"{url}/api/v1/scenes"))
        except (httpx.HTTPError, TimeoutError, ValidationError):
            return None
        workers = sum(it.status == EngineState.READY for it in readiness.workers)
        return Answers({it.id: it.loaded for it in scenes}, readiness.viewers, max(workers, 1))


async def _read(client: httpx.AsyncClient, url: str) -> bytes:
    """The body of a 200; httpx.HTTPError where there is none, or too much of it."""
    async with client.stream("GET", url) as response:
        if response.status_code != httpx.codes.OK:
            raise httpx.HTTPError(f"{url}: {response.status_code}")
        body = bytearray()
        async for part in response.aiter_raw():
            body += part
            if len(body) > MAX_ANSWER_BYTES:
                raise httpx.HTTPError(f"{url}: more than {MAX_ANSWER_BYTES} bytes")
    return bytes(body)
