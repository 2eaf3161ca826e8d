from dataclasses import replace
from signal import SIGKILL, SIGSEGV
from time import monotonic
from typing import Any

import pytest

from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from server.render.quarantine import (
    LIKE_STRIKES,
    LONG_SECONDS,
    MOST,
    SCENE_STRIKES,
    SUSPECT_SECONDS,
    Quarantine,
    QuarantinedError,
)
from server.wire.worker import HEARTBEAT, CloseScene, Export, Job, OpenScene, Pick, Render, SceneCamera, SceneRef

HALL = SceneRef("hall.glb", "/scenes/hall.glb", 1)
CRASH, KILLED = -SIGSEGV, -SIGKILL


def picture(scene: SceneRef = HALL, viewer: int = 3, size: tuple[int, int] = (8, 8), seed: int = 0) -> Render:
    return Render(viewer, scene, SceneCamera(0), size, RenderSettings(seed=seed), "jpeg")


def sized(size: tuple[int, int], settings: dict[str, Any]) -> Render:
    return replace(picture(size=size), settings=RenderSettings(**settings))


def is_out(quarantine: Quarantine, job: Job) -> bool:
    try:
        quarantine.check(job)
    except QuarantinedError as error:
        return str(error).startswith("hall.glb: ") and "ended the renderer" in str(error)
    return False


@pytest.mark.parametrize("job", [picture(), OpenScene(HALL)])
@pytest.mark.parametrize(
    ("seconds", "status", "hung", "times"),
    [
        (0.1, CRASH, False, 1),
        (0.1, 70, False, 1),
        (0.1, None, False, 1),
        (20.0, KILLED, True, 1),
        (LONG_SECONDS, KILLED, False, 1),
        (0.1, KILLED, False, 2),
    ],
)
def test_what_ended_a_worker_is_not_tried_again(
    job: Job, seconds: float, status: int | None, hung: bool, times: int
) -> None:
    quarantine = Quarantine()
    for _ in range(times):
        assert not is_out(quarantine, job)
        quarantine.blame(job, seconds, status, hung=hung)
    assert is_out(quarantine, job)


def test_a_picture_is_out_for_everybody_and_others_are_not() -> None:
    quarantine = Quarantine()
    quarantine.blame(picture(), 0.1, CRASH, hung=False)
    assert is_out(quarantine, replace(picture(viewer=9), view=SceneCamera(1), output=".png"))
    assert is_out(quarantine, replace(picture(), settings=RenderSettings(frames=9, exposure=2.0)))
    for other in (picture(size=(9, 8)), picture(seed=1), picture(replace(HALL, stamp=2)), OpenScene(HALL)):
        assert not is_out(quarantine, other)


@pytest.mark.parametrize(
    ("size", "settings", "out"),
    [
        ((64, 64), {"seed": 3}, True),
        ((65, 64), {}, True),
        ((63, 64), {"vpls": 1000}, True),
        ((640, 640), {"vpls": 999}, True),
        ((64, 64), {"fuzziness": 3, "near_field": False, "component": "direct"}, True),
        ((64, 31), {}, False),
        ((64, 64), {"vpls": 450}, False),
        ((640, 640), {"method": "path"}, False),
        ((640, 640), {"method": "fuzzy-vpl"}, False),
    ],
)
def test_what_costs_as_much_as_two_that_ended_workers_is_out_with_them(
    size: tuple[int, int], settings: dict[str, Any], out: bool
) -> None:
    quarantine, ended = Quarantine(), {"method": "exact-vpl", "vpls": 1000, "caustic_photons": 1}
    for seed in range(LIKE_STRIKES):
        assert not is_out(quarantine, sized(size, ended | settings))
        quarantine.blame(sized((64, 64), ended | {"seed": seed}), 0.1, CRASH, hung=False)
    assert is_out(quarantine, sized(size, ended | settings)) == out


def test_a_scene_that_ends_workers_when_read_is_out_in_every_picture() -> None:
    quarantine = Quarantine()
    quarantine.blame(OpenScene(HALL), 0.1, CRASH, hung=False)
    assert is_out(quarantine, picture())
    assert not is_out(quarantine, picture(replace(HALL, stamp=2)))


def test_a_scene_of_many_pictures_that_end_workers_is_out_unless_it_is_built_in() -> None:
    quarantine = Quarantine()
    built_in = SceneRef("hall.glb", "cornell-box")
    for seed in range(SCENE_STRIKES):
        assert not is_out(quarantine, picture(size=(1, 1)))
        quarantine.blame(picture(seed=seed), 0.1, CRASH, hung=False)
        quarantine.blame(picture(built_in, seed=seed), 0.1, CRASH, hung=False)
    assert is_out(quarantine, picture(size=(1, 1)))
    assert not is_out(quarantine, picture(built_in, size=(1, 1)))


def test_a_file_that_ends_workers_is_out_however_it_is_read() -> None:
    quarantine = Quarantine()
    for number in range(SCENE_STRIKES):
        moved = replace(HALL, options=ImportOptions(origin=(float(number), 0.0, 0.0)))
        assert not is_out(quarantine, picture(moved))
        quarantine.blame((OpenScene(moved), picture(moved))[number % 2], 0.1, CRASH, hung=False)
    assert is_out(quarantine, picture(replace(HALL, options=ImportOptions(origin=(9.0, 0.0, 0.0)))))
    assert is_out(quarantine, OpenScene(HALL))
    assert not is_out(quarantine, OpenScene(replace(HALL, stamp=2)))


@pytest.mark.parametrize("job", [Pick(HALL, SceneCamera(0), (8, 8), (0.5, 0.5)), Export(HALL)])
def test_other_work_that_ended_a_worker_is_out_and_pictures_are_not(job: Job) -> None:
    quarantine = Quarantine()
    quarantine.blame(job, 0.1, CRASH, hung=False)
    assert is_out(quarantine, job)
    assert not is_out(quarantine, picture())


def test_what_is_done_is_acquitted() -> None:
    quarantine = Quarantine()
    for _ in range(3):
        quarantine.blame(picture(), 0.1, KILLED, hung=False)
        quarantine.acquit(picture())
    assert not is_out(quarantine, picture())


def test_nobody_is_blamed_for_what_nobody_asked_for() -> None:
    quarantine = Quarantine()
    for job in (picture(viewer=HEARTBEAT), CloseScene(HALL)):
        quarantine.blame(job, 0.1, CRASH, hung=False)
        quarantine.check(job)
    quarantine.check(picture())


def test_a_bounded_number_is_remembered() -> None:
    quarantine = Quarantine()
    for seed in range(MOST + 1):
        quarantine.blame(picture(replace(HALL, stamp=seed), seed=seed), 0.1, CRASH, hung=False)
    assert not is_out(quarantine, picture(replace(HALL, stamp=0)))
    assert is_out(quarantine, picture(replace(HALL, stamp=1), seed=1))


def test_of_several_jobs_at_once_each_is_suspected_until_it_is_done_or_ends_a_worker_alone() -> None:
    quarantine = Quarantine()
    culprit, innocent = picture(seed=1), picture(seed=2)
    for _ in range(3):
        quarantine.suspect([culprit, replace(culprit, viewer=9), innocent, CloseScene(HALL)])
    assert quarantine.suspecting
    assert not is_out(quarantine, culprit)
    assert not is_out(quarantine, innocent)
    quarantine.acquit(innocent)
    assert quarantine.suspecting
    quarantine.blame(culprit, 0.1, CRASH, hung=False)
    assert not quarantine.suspecting
    assert is_out(quarantine, culprit)


def test_nobody_is_suspected_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    quarantine = Quarantine()
    quarantine.suspect([picture(seed=1)])
    now = monotonic()
    monkeypatch.setattr("server.render.quarantine.monotonic", lambda: now + SUSPECT_SECONDS + 1.0)
    quarantine.suspect([picture(seed=2)])
    assert quarantine.suspecting
    quarantine.acquit(picture(seed=2))
    assert not quarantine.suspecting


def test_suspicion_lasts_until_a_worker_was_there_for_long_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    quarantine, now = Quarantine(), monotonic()
    quarantine.suspect([picture(seed=1)])
    monkeypatch.setattr("server.render.quarantine.monotonic", lambda: now + 2.0 * SUSPECT_SECONDS)
    quarantine.renew()
    assert quarantine.suspecting
