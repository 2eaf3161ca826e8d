from typing import Any

import httpx
import pytest
from harness import Running

from server.rate_limit import Buckets

HALL = "/api/v1/scenes/rooms/hall.glb"
LEFT = {"scene": "rooms/hall.glb", "size": [80, 40], "pixel": [20.5, 20.5]}


def pick(running: Running, body: dict[str, Any]) -> httpx.Response:
    return running.http.post("/api/v1/pick", json=body)


def test_what_is_at_a_pixel_is_told(running: Running) -> None:
    chair = {"object": "chair", "material": "wall", "light": None, "point": None, "distance": 0.7}
    assert pick(running, LEFT).json() == chair
    lamp = pick(running, {"size": [80, 40], "pixel": [80, 40]}).json()
    assert (lamp["object"], lamp["light"], lamp["point"]) == (None, "lamp", [1.0, 0.0, -1.0])


def test_what_was_hidden_is_not_picked(running: Running) -> None:
    assert running.http.patch(HALL, json={"objects": {"chair": {"visible": False}}}).status_code == 200
    assert pick(running, LEFT).json()["object"] is None
    assert running.http.patch(HALL, json={"objects": None}).status_code == 200
    assert pick(running, LEFT).json()["object"] == "chair"


def test_a_client_can_have_edits_of_its_own(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = {**LEFT, "edits": {"objects": {"chair": {"visible": False}}}}
    assert pick(running, hidden).json()["object"] is None
    assert pick(running, LEFT).json()["object"] == "chair"
    still = {"size": [64, 36]}
    dark = {**still, "edits": {"lights": {"lamp": {"on": False}}}}
    pictures = [running.http.post("/api/v1/render", json=body).content for body in (still, dark)]
    assert pictures[0] != pictures[1]
    monkeypatch.setattr(running.service, "settings", running.service.settings.model_copy(update={"edits": False}))
    assert pick(running, hidden).status_code == 403


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"size": [80, 40], "pixel": [80.5, 20]}, "pixel: must be in the picture, from 0, 0 to 80, 40"),
        ({"size": [80, 40], "pixel": [20, -1]}, "pixel.1: must be greater than or equal to 0"),
        ({"size": [0, 40], "pixel": [0, 0]}, "size.0: "),
        ({}, "pixel: is missing"),
        ({**LEFT, "camera": {"matrix": [0.0] * 16}}, "must be a rotation"),
    ],
)
def test_a_wrong_pick_is_refused_with_its_field(running: Running, body: dict[str, Any], words: str) -> None:
    answer = pick(running, body)
    assert answer.status_code == 422
    assert words in answer.json()["message"]


def test_nothing_is_picked_in_a_scene_that_there_is_not(running: Running) -> None:
    assert pick(running, {**LEFT, "scene": "nowhere.glb"}).status_code == 404


def test_who_picks_too_often_is_told_to_wait(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running.service, "pick_rates", Buckets(1e-3, 1.0))
    assert pick(running, LEFT).status_code == 200
    answer = pick(running, LEFT)
    assert (answer.status_code, answer.headers["Retry-After"]) == (429, "2")
