import io
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from glb_file import TRIANGLE_GLB
from gradient_worker import SLOW_SEED
from harness import Running, Walker, wait_for

from gpu.scene.edits import LightEdit, SceneEdits
from server.rate_limit import Buckets
from server.scenes.uploads import MAX_AT_ONCE

SCENES = "/api/v1/scenes"


def listed(running: Running) -> dict[str, Any]:
    return {scene["id"]: scene for scene in running.http.get(SCENES).json()}


def upload(running: Running, name: str = "house.glb", content: bytes = TRIANGLE_GLB) -> httpx.Response:
    return running.http.post(SCENES, params={"name": name}, content=content)


def events(response: httpx.Response) -> Iterator[tuple[str, dict[str, Any]]]:
    """The server-sent events of a response: names and data."""
    for part in response.text.split("\n\n"):
        if part:
            name, data = part.split("\n", 1)
            yield name.removeprefix("event: "), json.loads(data.removeprefix("data: "))


@pytest.fixture
def service(serve: Callable[..., Running], tmp_path: Path) -> Running:
    """A service of one's own, with a folder of two scenes, one of them broken."""
    (tmp_path / "hall.glb").write_bytes(b"12345")
    (tmp_path / "broken.glb").write_bytes(b"")
    return serve(scenes_dir=tmp_path)


def test_scenes_are_listed_with_what_is_known_of_them(running: Running) -> None:
    scenes = running.http.get(SCENES).json()
    assert scenes[0]["id"] == "cornell-box"
    assert (scenes[0]["builtin"], scenes[0]["served"], scenes[0]["loaded"]) == (True, True, True)
    hall = listed(running)["rooms/hall.glb"]
    assert (hall["name"], hall["builtin"], hall["served"], hall["uploaded"]) == ("hall", False, False, False)
    assert hall["bytes"] == 0


def test_a_scene_is_described_without_loading_it(running: Running) -> None:
    described = running.http.get(f"{SCENES}/rooms/hall.glb").json()
    assert described["scene"]["triangles"] == 12
    assert described["device_bytes"] > 0
    assert "method" in described["settings_schema"]["properties"]
    assert not described["loaded"]


def test_a_scene_is_loaded_and_unloaded(service: Running) -> None:
    answer = service.http.post(f"{SCENES}/hall.glb/load")
    assert answer.status_code == 200
    assert answer.json()["scene"]["cameras"][0]["name"] == "front"
    assert answer.json()["memory_total"] > answer.json()["memory_used"] > 0
    assert listed(service)["hall.glb"]["loaded"]
    assert service.http.post(f"{SCENES}/hall.glb/unload").status_code == 200
    assert not listed(service)["hall.glb"]["loaded"]
    assert service.http.post(f"{SCENES}/hall.glb/unload").status_code == 200  # as asked for already


def test_loading_tells_its_progress(service: Running) -> None:
    told = list(events(service.http.post(f"{SCENES}/hall.glb/load", headers={"Accept": "text/event-stream"})))
    assert told[0] == ("progress", {"text": "checking hall.glb", "fraction": 0.0})
    assert told[-1][0] == "end"
    assert told[-1][1]["loaded"]


def test_an_error_in_loading_is_the_last_event(service: Running) -> None:
    told = list(events(service.http.post(f"{SCENES}/broken.glb/load", headers={"Accept": "text/event-stream"})))
    assert told[-1] == ("error", {"code": "bad-request", "message": "broken.glb: accessors[0]: is cut off"})


def test_a_broken_scene_is_refused(service: Running) -> None:
    response = service.http.post(f"{SCENES}/broken.glb/load")
    assert (response.status_code, response.json()["code"]) == (422, "bad-request")


@pytest.mark.parametrize("action", ["load", "unload"])
def test_an_unknown_scene_is_not_found(running: Running, action: str) -> None:
    assert running.http.post(f"{SCENES}/nowhere.glb/{action}").status_code == 404


def test_a_scene_that_is_looked_at_is_not_unloaded(service: Running, visit: Callable[[Running], Walker]) -> None:
    walker = visit(service)
    walker.hello(scene="hall.glb")
    response = service.http.post(f"{SCENES}/hall.glb/unload")
    assert (response.status_code, response.json()["code"]) == (409, "in-use")
    assert listed(service)["hall.glb"]["viewed"]


def test_a_scene_that_does_not_fit_is_refused_before_it_is_tried(serve: Callable[..., Running], tmp_path: Path) -> None:
    (tmp_path / "hall.glb").write_bytes(b"")
    service = serve(scenes_dir=tmp_path, reserve_bytes=2**40)
    response = service.http.post(f"{SCENES}/hall.glb/load")
    assert (response.status_code, response.json()["code"]) == (507, "no-room")
    assert "needs about 67 MB" in response.json()["message"]
    assert "cornell-box" in response.json()["message"]  # which could be unloaded
    assert not listed(service)["hall.glb"]["loaded"]


def test_an_upload_can_be_chosen_at_once(running: Running) -> None:
    response = upload(running)
    assert response.status_code == 201, response.text
    described = response.json()
    assert response.headers["Location"] == f"{SCENES}/{described['id']}"
    assert (described["id"], described["name"], described["uploaded"]) == ("uploads/house.glb", "house", True)
    assert described["bytes"] >= len(TRIANGLE_GLB)
    assert upload(running).json()["id"] == "uploads/house-2.glb"
    response = running.http.post("/api/v1/render", json={"scene": described["id"], "size": [8, 8]})
    assert response.status_code == 200
    assert listed(running)[described["id"]]["loaded"]


def test_an_upload_can_be_deleted_and_leaves_the_device(service: Running) -> None:
    scene_id = upload(service).json()["id"]
    service.http.post(f"{SCENES}/{scene_id}/load")
    assert service.http.delete(f"{SCENES}/{scene_id}").status_code == 204
    assert scene_id not in listed(service)
    assert all(ref.id != scene_id for ref in service.service.engines.scenes)
    assert service.http.delete(f"{SCENES}/{scene_id}").status_code == 404


def test_what_is_uploaded_again_takes_over_edits_that_fit(service: Running) -> None:
    place = upload(service).headers["Location"]
    service.http.patch(place, json={"lights": {"lamp": {"on": False}}}).raise_for_status()
    again = upload(service)
    assert again.json()["id"] == "uploads/house-2.glb"
    assert again.json()["edits"]["lights"]["lamp"]["on"] is False
    assert upload(service, "other.glb").json()["edits"]["lights"] == {}
    service.http.patch(again.headers["Location"], json={"lights": None}).raise_for_status()
    assert upload(service).json()["edits"]["lights"] == {}  # of the newest
    assert service.http.get(place).json()["edits"]["lights"]["lamp"]["on"] is False
    read_otherwise = service.http.post(SCENES, params={"name": "house.glb", "unit": "mm"}, content=TRIANGLE_GLB)
    assert read_otherwise.json()["edits"]["lights"] == {}


def test_what_is_uploaded_again_is_kept_where_the_file_before_is_gone(service: Running) -> None:
    before = upload(service).json()["id"]
    Path(service.service.catalogue.find(before).source).unlink()
    again = upload(service)
    assert (again.status_code, again.json()["id"]) == (201, "uploads/house-2.glb")


def test_an_upload_that_is_looked_at_is_not_deleted(service: Running, visit: Callable[[Running], Walker]) -> None:
    scene_id = upload(service).json()["id"]
    visit(service).hello(scene=scene_id)
    assert service.http.delete(f"{SCENES}/{scene_id}").status_code == 409
    assert scene_id in listed(service)


@pytest.mark.parametrize("scene_id", ["cornell-box", "hall.glb"])
def test_only_uploads_can_be_deleted(service: Running, scene_id: str) -> None:
    assert service.http.delete(f"{SCENES}/{scene_id}").status_code == 403
    assert scene_id in listed(service)


def test_an_upload_needs_the_name_of_a_scene(running: Running) -> None:
    for name in ("house.exe", "house", ""):
        response = upload(running, name)
        assert response.status_code == 422
        assert ".glb" in response.json()["message"]
    assert running.http.post(SCENES, content=b"x").status_code == 422


def test_an_upload_is_no_form(running: Running) -> None:
    answer = running.http.post(SCENES, params={"name": "house.glb"}, files={"file": TRIANGLE_GLB})
    assert answer.status_code == 422
    assert answer.json()["message"].startswith("body: is a form; send the file itself")


def test_a_service_may_take_no_uploads(serve: Callable[..., Running]) -> None:
    response = upload(serve(uploads=False))
    assert (response.status_code, response.json()["code"]) == (403, "forbidden")


def test_an_upload_that_is_too_large_is_refused(serve: Callable[..., Running]) -> None:
    service = serve(max_upload_bytes=100_000)
    assert upload(service, content=b" " * 100_001).status_code == 413
    chunks = (b" " * 10_000 for _ in range(11))
    assert service.http.post(SCENES, params={"name": "a.glb"}, content=chunks).status_code == 413
    assert upload(service, content=b" " * 90_000).status_code == 201  # more than other bodies may have


def test_uploads_go_with_the_service(serve: Callable[..., Running]) -> None:
    service = serve()
    upload(service)
    uploads = service.service.catalogue.uploads
    assert uploads is not None
    folder = uploads.path(uploads.all["uploads/house.glb"])
    assert folder.is_file()
    uploads.close()
    assert not folder.exists()


def test_a_load_is_told_while_the_device_is_busy(service: Running) -> None:
    slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
    busy = threading.Thread(target=lambda: service.http.post("/api/v1/render", json=slow))
    busy.start()
    assert service.http.post(f"{SCENES}/hall.glb/load").status_code == 200
    busy.join()


@pytest.mark.parametrize("name", ["日本.glb", "ein haus é.glb"])
def test_any_letters_may_be_in_the_name_of_an_upload(service: Running, name: str) -> None:
    answer = upload(service, name)
    assert answer.status_code == 201
    assert service.http.get(answer.headers["Location"]).json()["id"] == f"uploads/{name}"


def test_a_file_that_has_gone_does_not_hide_the_others(service: Running, tmp_path: Path) -> None:
    assert "hall.glb" in listed(service)
    (tmp_path / "hall.glb").unlink()
    assert "broken.glb" in listed(service)
    assert "hall.glb" not in listed(service)


def test_who_leaves_while_a_scene_is_loaded_leaves_nothing_behind(
    service: Running, caplog: pytest.LogCaptureFixture
) -> None:
    engine = service.service.engines
    before = len(engine.listeners)
    with service.walker() as walker:
        walker.hello(settings={"seed": SLOW_SEED})
        walker.pose(1)
        url = f"{SCENES}/hall.glb/load"
        with service.http.stream("POST", url, headers={"Accept": "text/event-stream"}) as answer:
            next(answer.iter_lines())
    wait_for(lambda: len(engine.listeners) <= before)
    assert "Exception" not in caplog.text


def test_an_upload_that_is_cut_off_leaves_nothing_and_no_traceback(
    service: Running, caplog: pytest.LogCaptureFixture
) -> None:
    uploads = service.service.catalogue.uploads
    assert uploads is not None
    url = service.http.base_url
    with socket.create_connection((url.host, url.port)) as connection:
        head = f"POST {SCENES}?name=house.glb HTTP/1.1\r\nHost: {url.netloc.decode()}\r\nContent-Length: 100000\r\n\r\n"
        connection.sendall(head.encode() + b"x" * 5000)
        wait_for(lambda: bool(uploads._taking))
    wait_for(lambda: not uploads._taking)
    time.sleep(0.1)
    assert not list(uploads._folder.iterdir())
    assert "Traceback" not in caplog.text


def test_an_upload_is_read_as_its_parameters_say(running: Running) -> None:
    reading = {"up": "z", "unit": "mm", "origin": "1,2,3", "storeys": ["ground, east", "first"]}
    answer = running.http.post(SCENES, params={"name": "turned.glb", **reading}, content=TRIANGLE_GLB).json()
    options = {**reading, "origin": [1, 2, 3], "variant": None}
    assert answer["scene"]["options"] == options
    address = f"{SCENES}/{answer['id']}"
    assert running.http.get(address).json()["scene"]["options"] == options
    assert running.http.get(address, params={"unit": "ft"}).json()["scene"]["options"]["unit"] == "ft"
    render = {"scene": answer["id"], "size": [8, 8], "scene_options": {"unit": "in"}}
    assert running.http.post("/api/v1/render", json=render).status_code == 200


@pytest.mark.parametrize(
    ("parameter", "words"),
    [({"up": "x"}, "up"), ({"unit": "km"}, "unit"), ({"origin": "1,2"}, "three numbers")],
    ids=str,
)
def test_a_way_to_read_that_cannot_be_is_refused(running: Running, parameter: dict[str, str], words: str) -> None:
    answer = running.http.post(SCENES, params={"name": "turned.glb", **parameter}, content=TRIANGLE_GLB)
    assert answer.status_code == 422
    assert words in answer.json()["message"]


def test_one_client_does_not_take_all_places_of_uploads(running: Running) -> None:
    with ExitStack() as others:
        for _ in range(MAX_AT_ONCE // 2):
            others.enter_context(running.service.uploading.taken("127.0.0.1"))
        answer = running.http.post("/api/v1/scenes?name=a.obj", content=b"v 0 0 0")
        assert (answer.status_code, answer.json()["code"]) == (429, "too-busy")


def test_a_scene_is_edited_and_tells_what_differs(service: Running) -> None:
    place = f"{SCENES}/hall.glb"
    edited = service.http.patch(
        place, json={"lights": {"lamp": {"intensity": 0.5}}, "materials": {"wall": {"metallic": 1}}}
    )
    assert edited.status_code == 200
    assert edited.json()["lights"]["lamp"]["intensity"] == 0.5
    service.http.patch(place, json={"materials": None})
    told = service.http.get(place).json()["edits"]
    assert SceneEdits.model_validate(told) == SceneEdits(lights={"lamp": LightEdit(intensity=0.5)})
    request = {"size": [32, 18], "scene": "hall.glb"}
    picture = service.http.post("/api/v1/render", json=request, headers={"Accept": "application/x-npy"})
    assert np.load(io.BytesIO(picture.content))[0, -1, 0] == 0.5
    job = service.http.post("/api/v1/jobs", json={**request, "format": "npy"}).json()["url"]
    list(events(service.http.get(f"{job}/events")))
    assert np.load(io.BytesIO(service.http.get(f"{job}/result").content))[0, -1, 0] == 0.5


@pytest.mark.parametrize(
    ("patch", "words"),
    [
        ({"lights": {"moon": {"on": True}}, "materials": {"wall": {"metallic": 1}}}, "lights.moon: the scene has no"),
        ({"lights": {"lamp": {"on": "perhaps"}}}, "lights.lamp.on: "),
        ({"cameras": {}}, "cameras: "),
        ([], "must be"),
    ],
)
def test_a_wrong_edit_is_refused_with_its_field(running: Running, patch: object, words: str) -> None:
    answer = running.http.patch(f"{SCENES}/rooms/hall.glb", json=patch)
    assert answer.status_code == 422
    assert words in answer.json()["message"]
    told = running.http.get(f"{SCENES}/rooms/hall.glb").json()["edits"]
    assert SceneEdits.model_validate(told) == SceneEdits()


def test_who_edits_too_often_is_told_to_wait(service: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service.service, "edit_rates", Buckets(1e-3, 1.0))
    assert service.http.patch(f"{SCENES}/hall.glb", json={}).status_code == 200
    answer = service.http.patch(f"{SCENES}/hall.glb", json={})
    assert (answer.status_code, answer.headers["Retry-After"]) == (429, "2")
