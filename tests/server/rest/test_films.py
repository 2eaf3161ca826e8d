import io
import sys
from collections.abc import Callable
from typing import Any

import pytest
from gradient_worker import SLOW_SEED
from harness import Running

pytest.importorskip("av", reason="the extra video is not installed")
FILMS = "/api/v1/films"
IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def path(*times: float) -> dict[str, Any]:
    """Keyframes along x, a metre a second."""
    return {"keyframes": [{"time": t, "camera": {"matrix": [*IDENTITY[:12], t, 0, 0, 1]}} for t in times]}


def along(camera: str) -> dict[str, Any]:
    """From the scene's first camera to another of its own."""
    return {"keyframes": [{"time": 0, "camera": 0}, {"time": 1, "camera": camera}]}


def film(**fields: Any) -> dict[str, Any]:
    return {"path": path(0, 0.5), "size": [16, 8], "film": {"fps": 8}} | fields


def test_a_film_is_a_job_whose_result_plays(running: Running) -> None:
    import av

    response = running.http.post(FILMS, json=film(settings={"frames": 3}))
    assert response.status_code == 202, response.text
    job = response.json()
    assert response.headers["Location"] == job["url"]
    assert (job["frames"], job["pictures"], job["format"]) == (12, 4, "video/mp4")
    job = running.ended(job)
    assert (job["state"], job["frames_done"], job["progress"]) == ("done", 12, 1.0)
    result = running.http.get(f"{job['url']}/result")
    assert result.headers["Content-Type"] == "video/mp4"
    with av.open(io.BytesIO(result.content)) as container:
        frames = list(container.decode(video=0))
    assert [(frame.width, frame.height) for frame in frames] == [(16, 8)] * 4


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"path": path(0)}, "path.keyframes: needs 2 or more, has 1"),
        ({"path": path(1, 0)}, "path.keyframes: times must increase; [1] has 0 after 1"),
        ({"path": path(0, 3600), "film": {"fps": 60}}, "keyframes: 3600 s are 216000 pictures at 60 a second"),
        ({"size": [15, 8]}, "size: a video needs even sides, which 15x8 has not; ask for 16x8"),
        ({"film": {"codec": "gif"}}, "film.codec: must be 'h264' or 'av1'"),
        ({"settings": {"samples": 65}}, "settings.samples: 65 is more than this server's limit of 64"),
        ({"camera": 0}, "camera: is not known here"),
        ({"path": along("attic")}, "keyframes[1].camera: cornell-box has no camera 'attic'; it has 0 ("),
        ({"edits": {"objects": {"sofa": {}}}}, "objects.sofa: the scene has no such object; it has "),
    ],
)
def test_what_is_wrong_is_named(running: Running, fields: dict[str, Any], words: str) -> None:
    response = running.http.post(FILMS, json=film(**fields))
    assert response.status_code == 422
    assert response.json()["message"].startswith(words)


def test_a_film_that_takes_too_long_is_refused_with_what_would_do(serve: Callable[..., Running]) -> None:
    running = serve(max_render_seconds=60.0)
    wanted = film(path=path(0, 60), size=[1280, 720], settings={"method": "path", "samples": 4096, "frames": 16})
    response = running.http.post(FILMS, json=wanted)
    assert (response.status_code, response.json()["code"]) == (422, "too-long")
    message = response.json()["message"]
    assert message.startswith("size: 480 pictures of 1280×720 pixels with these settings and ")
    assert "frames each are expected to take" in message
    assert running.http.get("/api/v1/jobs").json() == []


def test_a_film_can_be_cancelled(running: Running) -> None:
    job = running.http.post(FILMS, json=film(settings={"frames": 8, "seed": SLOW_SEED})).json()
    assert running.http.delete(job["url"]).json()["state"] == "cancelled"
    assert running.http.get(job["url"]).status_code == 404


def test_without_pyav_the_extra_is_named(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    response = running.http.post(FILMS, json=film())
    assert response.status_code == 422
    assert response.json()["message"] == "video needs the extra video: pip install lumenwalk[video]"
