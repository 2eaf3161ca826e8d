from dataclasses import replace

import numpy as np
import pytest

from server.render.activity import EngineState
from server.render.placement import Candidate, choose
from tests.bench import fleet
from tests.bench.fleet import Fleet, Simulation, frames_a_second, gpus_needed

SMALL = Fleet(
    gpus=8, gpus_a_node=2, viewers=60, scenes=12, scenes_a_gpu=5, frames_a_second=100.0, moving=0.5,
    stay_seconds=60.0, warm_up_seconds=60.0, seconds=120.0,
)  # fmt: skip


def test_costs_are_those_that_were_measured() -> None:
    assert frames_a_second((480, 270)) == 428.8
    assert frames_a_second((320, 180)) == 671.8


def test_viewers_are_placed_by_the_rule_of_the_service() -> None:
    simulation = Simulation(replace(SMALL, one_load=True))
    random = np.random.default_rng(2)
    for _ in range(50):
        simulation.clients[:] = random.integers(0, 12, SMALL.gpus)
        simulation.up[:] = random.random(SMALL.gpus) < 0.8
        simulation.up[0] = True
        simulation.ready_at[:, 3] = np.where(random.random(SMALL.gpus) < 0.4, 0.0, np.inf)
        simulation._loader_free_at[:] = np.where(random.random(SMALL.gpus) < 0.4, 10.0, 0.0)
        loads = simulation._loader_free_at > simulation.now
        states = [EngineState.READY if up else EngineState.FAILED for up in simulation.up]
        holds = simulation.ready_at[:, 3] < np.inf
        fleet = [
            Candidate(state, bool(has), True, bool(at_another), int(clients), 0.0)
            for state, has, at_another, clients in zip(states, holds, loads, simulation.clients, strict=True)
        ]
        assert simulation.place(3) == choose(fleet)


def test_nobody_is_placed_where_no_gpu_has_room() -> None:
    simulation = Simulation(Fleet(gpus=1, viewers=0, scenes=2, scenes_a_gpu=1))
    assert simulation._enter(0, 1) == pytest.approx(10.0, abs=0.1)
    assert simulation._enter(1, 2) is None
    assert simulation._enter(0, 3) == pytest.approx(10.0, abs=0.1)  # it comes while the scene is loaded


def test_scenes_are_loaded_one_after_another_and_those_that_nobody_uses_make_room() -> None:
    simulation = Simulation(Fleet(gpus=1, viewers=0, scenes=3, scenes_a_gpu=2))
    assert [round(simulation._enter(scene, scene) or 0.0) for scene in range(2)] == [10, 20]
    simulation.now = 30.0
    simulation._departure(0)
    assert round(simulation._enter(2, 2) or 0.0) == 10
    assert np.isinf(simulation.ready_at[0]).tolist() == [True, False, False]


@pytest.mark.parametrize(("one_load", "gpu"), [(False, 0), (True, 1)])
def test_a_gpu_that_loads_is_spared_by_choice(one_load: bool, gpu: int) -> None:
    simulation = Simulation(Fleet(gpus=2, viewers=0, scenes=3, one_load=one_load))
    simulation._load(0, 0)
    simulation.clients[:] = 0, 3
    assert simulation.place(1) == gpu
    assert simulation.place(0) == 0  # whose viewers wait for that scene anyway


def test_counts_fit_at_every_end() -> None:
    simulation = Simulation(Fleet(**vars(SMALL) | {"loss_seconds": 60.0, "back_seconds": 20.0}))
    outcome = simulation.run()
    assert outcome.losses == 2
    assert len(simulation._viewers) == simulation.clients.sum() == simulation.users.sum()
    assert (simulation._wanted == np.count_nonzero(simulation.users, axis=1)).all()
    assert simulation._wanted.max() <= SMALL.scenes_a_gpu
    assert len(outcome.again) > 5
    assert max(outcome.again) >= SMALL.load_seconds


def test_more_gpus_are_needed_where_more_viewers_move() -> None:
    few, many = (gpus_needed(Fleet(**vars(SMALL) | {"moving": moving, "scenes_a_gpu": 12})) for moving in (0.2, 1.0))
    assert few < many
    assert many >= 60 * 25 / 100  # not fewer than the mean would need


def test_the_tables_are_printed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(fleet, "Fleet", lambda **_: SMALL)
    fleet.main()
    lines = capsys.readouterr().out.splitlines()
    assert len([line for line in lines if line.startswith("| ")]) == 2 + 4 + 2 + 9
    assert any("viewers, picture again" in line for line in lines)
