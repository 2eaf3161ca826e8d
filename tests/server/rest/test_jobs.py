import io
import json
from collections.abc import Callable
from typing import Any

import pytest
from gradient_worker import SLOW_SEED, WRONG_SEED
from harness import Running
from PIL import Image

JOBS = "/api/v1/jobs"


def post(running: Running, **fields: Any) -> dict[str, Any]:
    response = running.http.post(JOBS, json={"size": [16, 8]} | fields)
    assert response.status_code == 202, response.text
    job: dict[str, Any] = response.json()
    assert response.headers["Location"] == job["url"]
    return job


def test_a_job_is_rendered_and_its_result_fetched(running: Running) -> None:
    job = post(running, format="png", settings={"frames": 5})
    assert (job["state"], job["frames"], job["scene"]) == ("queued", 5, "cornell-box")
    job = running.ended(job)
    assert (job["state"], job["progress"], job["frames_done"], job["format"]) == ("done", 1.0, 5, "image/png")
    result = running.http.get(f"{job['url']}/result")
    assert result.headers["Content-Type"] == "image/png"
    assert Image.open(io.BytesIO(result.content)).size == (16, 8)
    assert job["id"] in [listed["id"] for listed in running.http.get(JOBS).json()]


@pytest.mark.parametrize(
    ("format_", "magic"), [("jpg", b"\xff\xd8\xff"), ("exr", b"\x76\x2f\x31\x01"), ("npy", b"\x93NUMPY")]
)
def test_the_result_has_the_format_asked_for(running: Running, format_: str, magic: bytes) -> None:
    job = running.ended(post(running, format=format_))
    assert running.http.get(f"{job['url']}/result").content.startswith(magic)


def test_many_paths_are_split_into_frames(serve: Callable[..., Running]) -> None:
    assert post(serve(), settings={"method": "path", "samples": 130})["frames"] == 3


def test_progress_is_told_until_the_end(running: Running) -> None:
    job = post(running, settings={"frames": 4, "seed": SLOW_SEED})
    told = []
    with running.http.stream("GET", f"{job['url']}/events") as response:
        assert response.headers["Content-Type"].startswith("text/event-stream")
        for line in response.iter_lines():
            if line.startswith("data: "):
                told.append(json.loads(line.removeprefix("data: ")))
    assert told[-1]["state"] == "done"
    progress = [now["progress"] for now in told]
    assert progress == sorted(progress)
    assert len(set(progress)) > 2


def test_a_result_that_is_not_there_is_a_conflict(running: Running) -> None:
    job = post(running, settings={"frames": 20, "seed": SLOW_SEED})
    response = running.http.get(f"{job['url']}/result")
    assert (response.status_code, response.json()["code"]) == (409, "not-yet")
    cancelled = running.http.delete(job["url"])
    assert cancelled.json()["state"] == "cancelled"
    assert running.http.get(job["url"]).status_code == 404


def test_a_failed_job_says_why(running: Running) -> None:
    job = running.ended(post(running, settings={"seed": WRONG_SEED}))
    assert (job["state"], job["error"]) == ("failed", "settings.seed: is the wrong one")
    assert "wrong one" in running.http.get(f"{job['url']}/result").json()["message"]


def test_a_camera_or_part_that_a_file_lacks_is_refused_at_once(running: Running) -> None:
    for wanted, words in (
        ({"camera": "attic"}, "camera: rooms/hall.glb has no camera 'attic'; it has 0 (front)"),
        ({"camera": 1}, "camera: rooms/hall.glb has no camera 1; it has 0 (front)"),
        ({"edits": {"lights": {"moon": {"on": False}}}}, "lights.moon: the scene has no such light; it has none"),
    ):
        response = running.http.post(JOBS, json={"size": [16, 8], "scene": "rooms/hall.glb"} | wanted)
        assert (response.status_code, response.json()["message"]) == (422, words)
    job = running.ended(post(running, scene="rooms/hall.glb", camera="front"))
    assert job["state"] == "done"


def test_more_jobs_than_may_wait_are_turned_away(serve: Callable[..., Running]) -> None:
    running = serve(max_jobs=1)
    job = post(running, settings={"frames": 50, "seed": SLOW_SEED})
    response = running.http.post(JOBS, json={"size": [16, 8]})
    assert (response.status_code, response.json()["code"]) == (429, "too-busy")
    assert "Retry-After" in response.headers
    running.http.delete(job["url"])
    post(running)


def test_the_scene_of_a_job_is_not_unloaded(running: Running) -> None:
    job = post(running, settings={"frames": 20, "seed": SLOW_SEED})
    assert running.http.post("/api/v1/scenes/cornell-box/unload").status_code == 409
    running.http.delete(job["url"])


@pytest.mark.parametrize(
    ("fields", "place"),
    [({"format": "gif"}, "format"), ({"size": [0, 1]}, "size"), ({"settings": {"samples": 65}}, "settings.samples")],
)
def test_what_is_wrong_is_named(running: Running, fields: dict[str, Any], place: str) -> None:
    response = running.http.post(JOBS, json=fields)
    assert response.status_code == 422
    assert response.json()["message"].startswith(place)


def test_an_unknown_job_is_not_found(running: Running) -> None:
    for method, path in (("GET", ""), ("GET", "/result"), ("GET", "/events"), ("DELETE", "")):
        response = running.http.request(method, f"{JOBS}/nothing{path}")
        assert (response.status_code, response.json()["code"]) == (404, "unknown-job")


def test_events_end_when_the_service_does(serve: Callable[..., Running]) -> None:
    running = serve()
    job = post(running, settings={"frames": 200, "seed": SLOW_SEED})
    with running.http.stream("GET", f"{job['url']}/events") as response:
        lines = response.iter_lines()
        next(lines)
        running.service.stopping.set()
        assert all("end" not in line for line in lines if line.startswith("event: "))
