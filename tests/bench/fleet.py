"""Simulate many viewers on many GPUs: `python -m tests.bench.fleet` prints the tables of docs/fleet.md. No GPU is used.

Viewers arrive as a Poisson process and stay for exponential times; which scene they want follows Zipf's law. Each goes
where `server.render.placement` would send it and stays there. A GPU renders as many frames a second as was measured
(tests/bench/results/viewers-h100.json) and shares them among those of its viewers who move; pictures of the others are
final. It loads one scene after another. Nodes are lost with all that was on them, and come back empty.
"""

import json
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from server.render.placement import LOADING

MEASURED = Path(__file__).parent / "results" / "viewers-h100.json"
SIZE = (480, 270)
WANTED = 25.0  # frames a second of a viewer who moves
SAMPLE_SECONDS = 5.0


def frames_a_second(size: tuple[int, int] = SIZE) -> float:
    """What one GPU was measured to render of this size for sixteen viewers, in as many lanes as are best."""
    rows = json.loads(MEASURED.read_text())["rows"]
    return max(float(row["frames_a_second"]) for row in rows if tuple(row["size"]) == size)


@dataclass(frozen=True)
class Fleet:
    """What is simulated; times in seconds.

    viewers: on average at a time; moving: their share that moves; zipf: its exponent; scenes_a_gpu: as --max-scenes;
    one_load: a GPU that loads a scene is sent no viewer of another one that it has not, unless no other fits;
    loss_seconds: between losses of a node, none if 0; back_seconds: until it is there again.
    """

    gpus: int = 200
    gpus_a_node: int = 8
    viewers: int = 10_000
    moving: float = 0.3
    stay_seconds: float = 900.0
    scenes: int = 1000
    zipf: float = 1.0
    scenes_a_gpu: int = 16
    load_seconds: float = 10.0
    one_load: bool = False
    frames_a_second: float = field(default_factory=frames_a_second)
    loss_seconds: float = 0.0
    back_seconds: float = 300.0
    warm_up_seconds: float = 1200.0
    seconds: float = 3600.0
    seed: int = 1


@dataclass
class Outcome:
    """What was seen after the warm-up: times to a first picture [s] of those who came and of those who had lost theirs,
    rates of viewers who move [frames/s], and counts.
    """

    first: list[float] = field(default_factory=list)
    again: list[float] = field(default_factory=list)
    rates: list[NDArray[np.float64]] = field(default_factory=list)
    loads: int = 0
    refused: int = 0
    losses: int = 0

    @property
    def served(self) -> float:
        """The share of moving viewers, over time, that gets the wanted rate."""
        return float(np.mean(np.concatenate(self.rates) >= WANTED))


class Simulation:
    """The state of a fleet: arrays over GPUs, and over GPUs and scenes."""

    def __init__(self, fleet: Fleet) -> None:
        self.fleet, self.outcome, self.now = fleet, Outcome(), 0.0
        self._random = np.random.default_rng(fleet.seed)
        popularity = np.arange(1, fleet.scenes + 1) ** -fleet.zipf
        self._popular = np.cumsum(popularity / popularity.sum())
        shape = fleet.gpus, fleet.scenes
        self.up = np.ones(fleet.gpus, bool)
        self.clients = np.zeros(fleet.gpus, int)
        self.users = np.zeros(shape, int)  # viewers of a scene on a GPU
        self._wanted = np.zeros(fleet.gpus, int)  # scenes on a GPU that have viewers
        self.ready_at = np.full(shape, np.inf)  # when a scene is, or was, on a GPU; infinity: it is not to come
        self._used_at = np.zeros(shape)
        self._loader_free_at = np.zeros(fleet.gpus)
        self._viewers: dict[int, tuple[int, int]] = {}  # GPU and scene
        self._number = 0
        self._events: list[tuple[float, int, str, int]] = []

    @property
    def _measures(self) -> bool:
        return self.now >= self.fleet.warm_up_seconds

    def run(self) -> Outcome:
        """Simulate the warm-up and the time after it."""
        fleet = self.fleet
        for _ in range(fleet.viewers):
            self._arrive()
        self._after(self._random.exponential(fleet.stay_seconds / fleet.viewers), "arrival")
        self._after(SAMPLE_SECONDS, "sample")
        if fleet.loss_seconds:
            self._after(fleet.warm_up_seconds + fleet.loss_seconds / 2, "loss")
        while self.now < fleet.warm_up_seconds + fleet.seconds:
            self.now, _, what, number = heappop(self._events)
            getattr(self, f"_{what}")(number)
        return self.outcome

    def place(self, scene: int) -> int | None:
        """The GPU for a viewer of a scene; None where none has room.

        As `server.render.placement.choose` has it, but for `one_load` where that is off.
        """
        holds = self.ready_at[:, scene] < np.inf
        fit = self.up & (holds | (self._wanted < self.fleet.scenes_a_gpu))
        if not fit.any():
            return None
        free = fit & (holds | (self._loader_free_at <= self.now))
        if self.fleet.one_load and free.any():
            fit = free
        crowd = np.where(fit, self.clients + np.where(holds, 0.0, LOADING), np.inf)
        least = np.flatnonzero(crowd == crowd.min())
        return int(least[np.argmax(holds[least])])

    def _after(self, seconds: float, what: str, number: int = 0) -> None:
        self._number += 1
        heappush(self._events, (self.now + seconds, self._number, what, number))

    def _arrival(self, _: int) -> None:
        self._arrive()
        self._after(self._random.exponential(self.fleet.stay_seconds / self.fleet.viewers), "arrival")

    def _arrive(self) -> None:
        scene = int(np.searchsorted(self._popular, self._random.random()))
        waited = self._enter(scene, self._number)
        if waited is None:
            self.outcome.refused += self._measures
            return
        if self._measures:
            self.outcome.first.append(waited)
        self._after(self._random.exponential(self.fleet.stay_seconds), "departure", self._number)

    def _enter(self, scene: int, viewer: int) -> float | None:
        """Put a viewer on a GPU; returns the time to its first picture, None where there is no room."""
        gpu = self.place(scene)
        if gpu is None:
            return None
        if self.ready_at[gpu, scene] == np.inf:
            self._load(gpu, scene)
        self._viewers[viewer] = gpu, scene
        self.clients[gpu] += 1
        self._wanted[gpu] += self.users[gpu, scene] == 0
        self.users[gpu, scene] += 1
        movers = 1.0 + self.fleet.moving * (self.clients[gpu] - 1)
        waits = max(float(self.ready_at[gpu, scene]) - self.now, 0.0)
        return waits + movers / self.fleet.frames_a_second  # a turn after each of the others

    def _load(self, gpu: int, scene: int) -> None:
        held = np.flatnonzero(self.ready_at[gpu] < np.inf)
        if len(held) >= self.fleet.scenes_a_gpu:
            idle = held[self.users[gpu, held] == 0]
            self.ready_at[gpu, idle[np.argmin(self._used_at[gpu, idle])]] = np.inf
        begins = max(self._loader_free_at[gpu], self.now)
        self._loader_free_at[gpu] = self.ready_at[gpu, scene] = begins + self.fleet.load_seconds
        self.outcome.loads += self._measures

    def _departure(self, viewer: int) -> None:
        if (left := self._viewers.pop(viewer, None)) is not None:
            self.clients[left[0]] -= 1
            self.users[left] -= 1
            self._wanted[left[0]] -= self.users[left] == 0
            self._used_at[left] = self.now

    def _sample(self, _: int) -> None:
        if self._measures:
            movers = self._random.binomial(self.clients, self.fleet.moving)
            movers = movers[movers > 0]
            self.outcome.rates.append(np.repeat(np.minimum(WANTED, self.fleet.frames_a_second / movers), movers))
        self._after(SAMPLE_SECONDS, "sample")

    def _loss(self, _: int) -> None:
        node = int(self._random.integers(-(-self.fleet.gpus // self.fleet.gpus_a_node)))
        gpus = slice(node * self.fleet.gpus_a_node, (node + 1) * self.fleet.gpus_a_node)
        self.up[gpus] = False
        self.clients[gpus], self.users[gpus], self._wanted[gpus], self.ready_at[gpus] = 0, 0, 0, np.inf
        for viewer, (gpu, scene) in list(self._viewers.items()):
            if not self.up[gpu]:
                del self._viewers[viewer]
                waited = self._enter(scene, viewer)
                self.outcome.refused += waited is None
                self.outcome.again += [] if waited is None else [waited]
        self.outcome.losses += 1
        self._after(self.fleet.back_seconds, "back", node)
        self._after(self.fleet.loss_seconds, "loss")

    def _back(self, node: int) -> None:
        gpus = slice(node * self.fleet.gpus_a_node, (node + 1) * self.fleet.gpus_a_node)
        self.up[gpus], self._loader_free_at[gpus] = True, self.now


def gpus_needed(fleet: Fleet, share: float = 0.95) -> int:
    """The fewest GPUs, in whole nodes, with which that share of moving viewers gets the wanted rate."""
    few, many = 0, -(-2 * fleet.viewers // fleet.gpus_a_node)
    while many - few > 1:
        nodes = (few + many) // 2
        enough = Simulation(replace(fleet, gpus=nodes * fleet.gpus_a_node)).run().served >= share
        few, many = (few, nodes) if enough else (nodes, many)
    return many * fleet.gpus_a_node


def _quantiles(seconds: list[float]) -> str:
    return " / ".join(f"{it:.2f}" for it in np.quantile(seconds, (0.5, 0.9, 0.99))) if seconds else "–"


def _row(*cells: Any) -> None:
    print("|", " | ".join(str(cell) for cell in cells), "|", flush=True)


def main() -> None:
    """Print the tables."""
    short = Fleet(warm_up_seconds=60.0, seconds=120.0, scenes_a_gpu=64)
    _row("share that moves", "GPUs needed", "viewers a GPU")
    _row("---", "---", "---")
    for moving in (1.0, 0.5, 0.3, 0.2):
        needed = gpus_needed(replace(short, moving=moving))
        _row(moving, needed, f"{short.viewers / needed:.1f}")
    print()
    _row("200 GPUs", "got 25/s", "rate p1 / p50", "first picture p50 / p90 / p99 [s]", "loads/min", "refused")
    _row(*["---"] * 6)
    usual = Fleet()
    cases = {
        f"{usual.scenes_a_gpu} scenes a GPU": usual,
        "4 scenes a GPU": replace(usual, scenes_a_gpu=4),
        "8 scenes a GPU": replace(usual, scenes_a_gpu=8),
        "first pictures after 3 s": replace(usual, load_seconds=3.0),
        "100 scenes": replace(usual, scenes=100),
        "10,000 scenes": replace(usual, scenes=10_000),
        "a node lost each 10 min": replace(usual, loss_seconds=usual.seconds / 6),
        "the same, one load at a time": replace(usual, loss_seconds=usual.seconds / 6, one_load=True),
        "the same, with 256 GPUs": replace(usual, loss_seconds=usual.seconds / 6, one_load=True, gpus=256),
    }
    lost = []
    for name, fleet in cases.items():
        seen = Simulation(fleet).run()
        rates = np.quantile(np.concatenate(seen.rates), (0.01, 0.5))
        asked = len(seen.first) + len(seen.again) + seen.refused
        cells = f"{seen.served:.1%}", f"{rates[0]:.1f} / {rates[1]:.1f}", _quantiles(seen.first)
        _row(name, *cells, f"{60 * seen.loads / fleet.seconds:.0f}", f"{seen.refused / asked:.2%}")
        if seen.losses:
            lost.append(
                f"{name}: {len(seen.again) / seen.losses:.0f} viewers, picture again {_quantiles(seen.again)} s"
            )
    print("", *lost, sep="\n")


if __name__ == "__main__":
    main()
