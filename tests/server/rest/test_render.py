import io
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx
import numpy as np
import pytest
from gradient_worker import BUG_SEED, DEADLY_SEED, SLOW_SEED, WRONG_SEED
from harness import IDENTITY, Running
from PIL import Image

RENDER = "/api/v1/render"


def post(running: Running, accept: str | None = None, **fields: Any) -> httpx.Response:
    return running.http.post(RENDER, json=fields, headers={"Accept": accept} if accept else None)


def test_a_size_alone_renders_the_served_scene(running: Running) -> None:
    response = post(running, size=[320, 180])
    assert response.status_code == 200, response.text
    assert response.headers["Content-Type"] == "image/png"
    image = Image.open(io.BytesIO(response.content))
    assert (image.format, image.size, image.mode) == ("PNG", (320, 180), "RGB")


def test_everything_has_a_default(running: Running) -> None:
    assert Image.open(io.BytesIO(post(running).content)).size == (1280, 720)


def test_statistics_are_in_the_headers(running: Running) -> None:
    headers = post(running, size=[32, 18]).headers
    assert json.loads(headers["X-Lumenwalk-Stage-Ms"]) == {"gbuffer": 0.5, "shade": 1.5, "extra": 2.0}
    assert json.loads(headers["X-Lumenwalk-Counts"]) == {"pixels": 32 * 18}
    assert json.loads(headers["X-Lumenwalk-Skips"]) == {"specular": 1}
    assert json.loads(headers["X-Lumenwalk-Estimates"]) == {"target_ms": 4.0}
    for name in ("Render", "Encode", "Queue"):
        assert float(headers[f"X-Lumenwalk-{name}-Ms"]) >= 0.0


@pytest.mark.parametrize(
    ("accept", "magic"),
    [("image/png", b"\x89PNG"), ("image/jpeg", b"\xff\xd8\xff"), ("image/x-exr", b"\x76\x2f\x31\x01")],
)
def test_the_format_follows_accept(running: Running, accept: str, magic: bytes) -> None:
    response = post(running, accept, size=[32, 18])
    assert response.headers["Content-Type"] == accept
    assert response.content.startswith(magic)


def test_npy_is_linear_radiance(running: Running) -> None:
    radiance = np.load(io.BytesIO(post(running, "application/x-npy", size=[32, 18]).content))
    assert radiance.dtype == np.float32
    assert radiance.shape == (18, 32, 3)
    np.testing.assert_allclose(radiance[0, :, 0], np.linspace(0.0, 1.0, 32), rtol=1e-6)


def test_a_format_that_cannot_be_written_is_refused(running: Running) -> None:
    response = post(running, "image/webp")
    assert (response.status_code, response.json()["code"]) == (406, "not-acceptable")


@pytest.mark.parametrize(
    "camera",
    [
        "front",
        {"position": [0, 1, 2], "target": [0, 0, 0]},
        {"position": [0, 1, 2], "target": [0, 0, 0], "up": [0, 0, 1], "yfov_degrees": 30},
        {"matrix": IDENTITY, "yfov_degrees": 45},
    ],
)
def test_a_camera_can_be_named_or_described(running: Running, camera: Any) -> None:
    assert post(running, size=[8, 8], camera=camera).status_code == 200


@pytest.mark.parametrize(
    ("fields", "place"),
    [
        ({"size": [0, 10]}, "size.0"),
        ({"size": [10]}, "size.1"),
        ({"size": [8192, 8192]}, "size"),
        ({"siez": [10, 10]}, "siez"),
        ({"settings": {"vpls": 0}}, "settings.vpls"),
        ({"settings": {"samples": 65}}, "settings.samples"),
        ({"settings": {"methd": "path"}}, "settings.methd"),
        ({"camera": -1}, "camera.index"),
        ({"camera": 1.5}, "camera.index"),
        ({"camera": {"position": [0, 0]}}, "camera.look-at.position"),
        ({"camera": {"matrix": [1, 2, 3]}}, "camera.matrix.matrix"),
        ({"camera": {"matrix": [2, *IDENTITY[1:]]}}, "camera.matrix.matrix"),
        ({"camera": "missing"}, "camera"),
        ({"settings": {"seed": WRONG_SEED}}, "settings.seed"),
    ],
)
def test_what_is_wrong_is_named(running: Running, fields: dict[str, Any], place: str) -> None:
    response = post(running, **fields)
    assert response.status_code == 422
    assert response.json()["message"].startswith(place)


@pytest.mark.parametrize("body", [b"{", b"[]", b'{"camera": {"position": [NaN, 0, 0], "target": [0, 0, 1]}}', b"\xff"])
def test_bodies_that_are_not_a_request_are_refused(running: Running, body: bytes) -> None:
    response = running.http.post(RENDER, content=body, headers={"Content-Type": "application/json"})
    assert response.status_code in (400, 422)
    assert response.json()["code"] == "bad-request"


def test_an_exposure_that_is_no_number_is_refused_with_the_range(running: Running) -> None:
    body = b'{"settings": {"exposure": Infinity}}'
    response = running.http.post(RENDER, content=body, headers={"Content-Type": "application/json"})
    words = "settings.exposure: must be a finite number above 0 and at most 1e+12"
    assert (response.status_code, response.json()["message"]) == (422, words)


@pytest.mark.parametrize("scene", ["nowhere", "../conftest.py", "/etc/passwd"])
def test_an_unknown_scene_is_not_found(running: Running, scene: str) -> None:
    response = post(running, scene=scene)
    assert (response.status_code, response.json()["code"]) == (404, "unknown-scene")


def test_a_bug_is_reported_without_its_traceback(running: Running) -> None:
    response = post(running, settings={"seed": BUG_SEED})
    assert (response.status_code, response.json()["code"]) == (500, "render-failed")
    assert "bug" not in response.json()["message"]


def test_the_interface_describes_itself(running: Running) -> None:
    paths = running.http.get("/api/openapi.json").json()["paths"]
    content = paths[RENDER]["post"]["responses"]["200"]["content"]
    assert set(content) == {"image/png", "image/jpeg", "image/x-exr", "application/x-npy"}


def test_a_render_that_loses_its_worker_is_answered_and_the_next_one_works(serve: Callable[..., Running]) -> None:
    running = serve()
    response = post(running, settings={"seed": DEADLY_SEED})
    assert (response.status_code, response.json()["code"]) == (503, "unavailable")
    assert int(response.headers["Retry-After"]) > 0
    running.wait_ready()
    assert post(running, size=[8, 8]).status_code == 200


def test_frames_are_averaged_and_their_times_added(running: Running) -> None:
    response = post(running, size=[32, 18], settings={"frames": 3})
    assert response.status_code == 200
    assert json.loads(response.headers["X-Lumenwalk-Stage-Ms"]) == {"gbuffer": 1.5, "shade": 4.5, "extra": 6.0}


def test_pictures_of_several_frames_do_not_mix(running: Running) -> None:
    def blue(_: int) -> float:
        response = post(running, "application/x-npy", size=[8, 8], settings={"frames": 4})
        return float(np.load(io.BytesIO(response.content))[0, 0, 2])

    with ThreadPoolExecutor(4) as pool:
        numbers = set(pool.map(blue, range(4)))
    assert len(numbers) == 4  # the gradient's blue is the viewer's number
    assert 0.0 not in numbers  # that of lone frames


def test_a_picture_of_too_many_frames_is_for_a_job(running: Running) -> None:
    response = post(running, size=[8, 8], settings={"frames": 65})
    assert response.status_code == 422
    assert "/api/v1/jobs" in response.json()["message"]


@pytest.mark.parametrize("path", ["/api/v1/render", "/api/v1/jobs"])
def test_what_is_expected_to_take_too_long_is_refused_before_it_begins(
    serve: Callable[..., Running], path: str
) -> None:
    large = {"size": [1920, 1080], "settings": {"method": "exact-vpl", "vpls": 1_000_000}}
    response = serve(max_render_seconds=60.0).http.post(path, json=large)
    assert (response.status_code, response.json()["code"]) == (422, "too-long")
    assert "ask for at most" in response.json()["message"]


def test_a_service_that_is_not_ready_says_when_to_try_again(serve: Callable[..., Running]) -> None:
    response = post(serve(ready=False))
    assert response.status_code == 503
    assert "Retry-After" in response.headers


def test_more_renders_than_may_wait_are_turned_away(serve: Callable[..., Running]) -> None:
    running = serve(max_waiting_renders=1)
    with ThreadPoolExecutor(4) as pool:
        slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
        responses = list(pool.map(lambda _: post(running, **slow), range(4)))
    statuses = sorted(response.status_code for response in responses)
    assert set(statuses) == {200, 429}
    assert all("Retry-After" in response.headers for response in responses if response.status_code == 429)


def test_a_render_does_not_wait_for_ever(serve: Callable[..., Running]) -> None:
    running = serve(max_wait_seconds=0.05)
    with ThreadPoolExecutor(2) as pool:
        slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
        statuses = sorted(response.status_code for response in pool.map(lambda _: post(running, **slow), range(2)))
    assert statuses == [200, 503]
