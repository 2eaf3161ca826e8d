"""What the stream does with those who ask for too much, and with edits."""

import asyncio
import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from socket import SHUT_RDWR
from threading import Event, Thread
from typing import Any

import pytest
import simplejpeg
from harness import IDENTITY, PATIENCE, Running, Walker, wait_for
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.scenes import changed_files
from server.walk import stream, viewer
from server.walk.viewer import MESSAGE_BURST, MESSAGE_RATE
from server.wire.browser import PROTOCOL, SceneInfo, parse_viewer_message
from server.wire.worker import SceneRef

Visit = Callable[[Running], Walker]
POSE = json.dumps({"type": "pose", "id": 1, "matrix": IDENTITY, "yfov": 1.0})


def consume(socket: ClientConnection) -> None:
    """Reads until the socket is closed."""
    while True:
        socket.recv(PATIENCE)


def code_of(socket: ClientConnection) -> int:
    """The code that the server closes with."""
    with pytest.raises(ConnectionClosed) as info:
        consume(socket)
    assert info.value.rcvd is not None
    return info.value.rcvd.code


def count(running: Running, name: str, **labels: str) -> float:
    return running.service.metrics.registry.get_sample_value(f"lumenwalk_{name}", labels) or 0.0


def test_a_message_that_is_too_big_is_refused_with_its_code(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.hello()
    # The beginning of a frame of so many bytes: the server does not wait for the rest.
    walker.socket.socket.sendall(b"\x81\xff" + (17 * 2**20).to_bytes(8, "big") + b"mask")
    assert code_of(walker.socket) == 1009
    visit(running).hello()


def test_a_flood_is_slowed_down_and_others_are_not(
    running: Running, visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = 0

    def counting(text: str) -> Any:
        nonlocal read
        read += 1
        return parse_viewer_message(text)

    monkeypatch.setattr(viewer, "parse_viewer_message", counting)
    hostile, other = visit(running), visit(running)
    other.hello()
    hostile.hello()
    seen = 0
    ended = Event()

    def flood() -> None:
        try:
            while not ended.is_set():
                hostile.socket.send(POSE)
        except ConnectionClosed:
            pass

    read = 0
    thread = Thread(target=flood, daemon=True)
    began = time.monotonic()
    thread.start()
    try:
        while seen < 6 or time.monotonic() - began < 1.5:
            seen += 1
            other.pose(seen)
            other.send("ack", frame=other.frame()[0].frame)
        was_read, took = read, time.monotonic() - began
    finally:
        ended.set()
    hostile.socket.socket.shutdown(SHUT_RDWR)  # which ends a send under way; close would not
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert was_read <= MESSAGE_BURST + MESSAGE_RATE * took + 3 * seen + 10


def test_who_says_nothing_takes_no_viewers_place(
    serve: Callable[..., Running], visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream, "MAX_GREETING", 2)
    monkeypatch.setattr(stream, "HELLO_SECONDS", PATIENCE)
    running = serve(max_viewers=1)
    silent: list[Walker] = []
    for _ in range(2):
        silent.append(visit(running))
        wait_for(lambda: len(running.service.greeting) == len(silent))
    visit(running).hello()
    assert code_of(silent[0].socket) == 1002  # made room
    assert running.service.viewers
    assert code_of(visit(running).socket) == 1013
    assert count(running, "refused_total", reason="full") == 1
    silent[1].send("hello", protocol=PROTOCOL, size=[64, 36])
    assert code_of(silent[1].socket) == 1013


def test_nobody_is_let_in_while_the_service_stops(serve: Callable[..., Running], visit: Visit) -> None:
    running = serve()
    running.service.stopping.set()
    assert code_of(visit(running).socket) == 1012
    response = running.http.get("/api/v1/scenes")
    assert (response.status_code, response.json()["code"]) == (503, "stopping")
    assert "Retry-After" in response.headers


def brightest(frame: tuple[object, bytes]) -> int:
    """The red of a picture's right end, which the lamp lights."""
    return int(simplejpeg.decode_jpeg(frame[1])[18, -2, 0])


def moving(walker: Walker) -> int:
    """How bright the next frame is."""
    frame = walker.frame()
    walker.send("ack", frame=frame[0].frame)
    return brightest(frame)


def test_an_edit_shows_in_the_next_frame_of_all_who_look(serve: Callable[..., Running], visit: Visit) -> None:
    running = serve()
    walkers = [visit(running), visit(running)]
    for walker in walkers:
        walker.hello()
        none = {"time": None, "animation": None, "lights": {}, "materials": {}, "objects": {}}
        assert walker.word("edits") == {
            "type": "edits",
            "scene": "cornell-box",
            "edits": none,
            "edit": 0,
            "own": False,
            "suns": {},
            "shared_over": None,
        }
        walker.pose(1)
        assert moving(walker) > 200
    walkers[0].send("edit", id=3, patch={"lights": {"lamp": {"on": False}}})
    for walker, edit in zip(walkers, (3, 0), strict=True):
        told = walker.word("edits")
        assert (told["edits"]["lights"]["lamp"]["on"], told["edit"]) == (False, edit)
        while moving(walker) > 50:  # those of before, that were on their way
            pass
    os.kill(running.service.engines.engines[0].worker_pid or 0, signal.SIGKILL)
    walkers[1].word("status", state="recovering")
    walkers[1].pose(2, x=0.5)
    while (shown := walkers[1].frame(60.0))[0].pose < 2:  # from another worker
        pass
    assert brightest(shown) < 50
    late = visit(running)
    late.hello()
    assert late.word("edits")["edits"]["lights"]["lamp"]["on"] is False


def test_edits_of_a_viewers_own_are_seen_by_nobody_else_until_it_shares_them(
    serve: Callable[..., Running], visit: Visit
) -> None:
    running = serve(max_own_edits=1)
    walkers = [visit(running), visit(running)]
    for walker in walkers:
        walker.hello()
        walker.word("edits")
        walker.pose(1)
        assert moving(walker) > 200
    mine, other = walkers
    mine.send("own", id=1, own=True)
    told = mine.word("edits")
    assert (told["own"], told["edit"]) == (True, 1)
    other.send("own", id=1, own=True)
    assert "as many as may" in other.word("error", code="edit-refused")["message"]
    mine.send("edit", id=2, patch={"lights": {"lamp": {"on": False}}})
    while moving(mine) > 50:
        pass
    other.pose(2, x=0.5)
    while (shown := other.frame())[0].pose < 2:
        other.send("ack", frame=shown[0].frame)  # else the window of frames may be full before
    other.send("ack", frame=shown[0].frame)
    assert brightest(shown) > 200
    assert running.http.get("/api/v1/scenes/cornell-box").json()["edits"]["lights"] == {}
    mine.send("own", id=3, own=False, share=True)
    while moving(other) > 50:
        pass
    assert running.http.get("/api/v1/scenes/cornell-box").json()["edits"]["lights"]["lamp"]["on"] is False
    told = mine.word("edits", edit=3)
    assert (told["own"], told["shared_over"]["lights"]) == (False, {})  # with which it can undo that
    mine.send("edit", id=4, patch={"lights": {"lamp": {"intensity": 2.0}}})
    assert mine.word("edits", edit=4)["shared_over"] is None


def test_long_edits_are_told_less_often(
    serve: Callable[..., Running], visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer, "EDITS_RATE", 500.0)
    walker = visit(serve())
    began = time.monotonic()
    walker.hello()
    walker.word("edits")
    for number in (1, 2):
        walker.send("edit", id=number, patch={"lights": {"lamp": {"intensity": number}}})
    walker.word("edits", edit=2)  # of 150 characters, as those before are
    assert time.monotonic() - began > 0.25


def test_a_bad_edit_changes_nothing_and_says_why(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.hello()
    walker.word("edits")
    walker.send("edit", id=1, patch={"lights": {"moon": {"on": False}}})
    error = walker.word("error", code="edit-refused")
    assert error["message"] == "lights.moon: the scene has no such light; it has lamp"
    assert error["edit"] == 1
    assert walker.word("edits")["edit"] == 1
    walker.send("edit", id=2, patch={"lights": {"lamp": {"intensity": -1}}})
    assert "patch.lights.lamp.intensity" in walker.word("error", code="edit-refused", edit=2)["message"]
    assert walker.word("edits")["edit"] == 2
    walker.send("edit", id=0, patch={})  # which nothing is answered to
    assert walker.word("error", code="bad-message")["message"].startswith("edit.id")


def test_a_service_may_take_no_edits(serve: Callable[..., Running], visit: Visit) -> None:
    running = serve(edits=False)
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36])
    assert walker.word("welcome")["takes_edits"] is False
    walker.word("edits")
    walker.send("edit", id=1, patch={"lights": {"lamp": {"on": False}}})
    assert walker.word("error")["message"] == "this server takes no edits of its scenes"
    answer = running.http.patch("/api/v1/scenes/cornell-box", json={})
    assert (answer.status_code, answer.json()["code"]) == (403, "forbidden")


def test_what_settings_there_are_is_found_out_once(
    running: Running, visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer.settings_schema.cache_clear()
    made, make = [], RenderSettings.model_json_schema
    monkeypatch.setattr(RenderSettings, "model_json_schema", lambda: made.append(1) or make())
    schemas = []
    for _ in range(2):
        walker = visit(running)
        walker.send("hello", protocol=PROTOCOL, size=[64, 36])
        schemas.append(walker.word("welcome")["settings_schema"])
    assert schemas[0] == schemas[1] == make()
    assert len(made) == 1


def test_who_looks_at_a_file_that_is_written_anew_sees_that_with_the_edits_that_fit(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(changed_files, "LOOK_SECONDS", 0.05)
    (tmp_path / "hall.glb").write_bytes(b"")
    running = serve(scenes_dir=tmp_path)
    walker = visit(running)
    walker.hello(scene="hall.glb")
    walker.send("edit", id=1, patch={"lights": {"lamp": {"on": False}}})
    edited = walker.word("edits", edit=1)["edits"]
    os.utime(tmp_path / "hall.glb", (2e9, 2e9))
    assert walker.word("scene")["id"] == "hall.glb"
    assert walker.word("edits")["edits"] == edited
    walker.pose(1)
    walker.frame()
    (scene,) = running.service.viewing.values()
    assert scene.stamp == 2e18


def test_who_chooses_another_scene_does_not_wait_for_the_one_before(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer, "LEFT_SECONDS", 0.1)
    for name in ("long.glb", "hall.glb"):
        (tmp_path / name).write_bytes(b"")
    running = serve(scenes_dir=tmp_path)
    residency, begun, abandoned = running.service.residency, Event(), Event()
    open_at_once = residency.open

    async def open_(scene: SceneRef, client: int) -> SceneInfo:
        try:
            if scene.id == "long.glb":
                begun.set()
                await asyncio.sleep(3600.0)
        except asyncio.CancelledError:
            abandoned.set()
            raise
        return await open_at_once(scene, client)

    monkeypatch.setattr(residency, "open", open_)
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36], scene="long.glb")
    assert begun.wait(PATIENCE)
    walker.send("settings", id=1, scene="hall.glb")
    assert walker.word("scene")["id"] == "hall.glb"
    assert abandoned.wait(PATIENCE)
    walker.pose(1)
    walker.frame()


def test_who_chooses_the_scene_again_that_is_read_has_it_read_on(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer, "LEFT_SECONDS", 0.2)
    for name in ("long.glb", "hall.glb"):
        (tmp_path / name).write_bytes(b"")
    running = serve(scenes_dir=tmp_path)
    residency, begun = running.service.residency, list[str]()
    open_at_once, first = residency.open, Event()

    async def open_(scene: SceneRef, client: int) -> SceneInfo:
        begun.append(scene.id)
        if scene.id == "long.glb":
            first.set()
            await asyncio.sleep(1.0)
        return await open_at_once(scene, client)

    monkeypatch.setattr(residency, "open", open_)
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36], scene="long.glb")
    assert first.wait(PATIENCE)
    walker.send("settings", id=1, scene="hall.glb")
    walker.send("settings", id=2, scene="long.glb")
    assert walker.word("scene")["id"] == "long.glb"
    assert begun == ["long.glb"]


def test_who_looks_at_a_scene_sees_what_is_written_anew_beside_it(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(changed_files, "LOOK_SECONDS", 0.05)
    (tmp_path / "hall.gltf").write_bytes(b"")
    (tmp_path / "wood.png").write_bytes(b"")
    running = serve(scenes_dir=tmp_path)
    walkers = [visit(running), visit(running)]
    walkers[0].hello(scene="hall.gltf")
    walkers[0].send("edit", id=1, patch={"lights": {"lamp": {"on": False}}})
    edited = walkers[0].word("edits", edit=1)["edits"]
    (before,) = running.service.viewing.values()
    os.utime(tmp_path / "wood.png", (1e9, 1e9))  # older than it was
    assert walkers[0].word("scene")["id"] == "hall.gltf"
    assert walkers[0].word("edits")["edits"] == edited
    walkers[1].hello(scene="hall.gltf")
    walkers[1].word("edits")
    (now,) = {*running.service.viewing.values()}
    assert now != before
    with pytest.raises(TimeoutError):
        walkers[0].word("scene", timeout=0.5)


def test_a_file_that_becomes_a_broken_one_is_told_and_the_one_before_is_still_shown(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(changed_files, "LOOK_SECONDS", 0.05)
    (tmp_path / "hall.glb").write_bytes(b"")
    running = serve(scenes_dir=tmp_path)
    walker = visit(running)
    walker.hello(scene="hall.glb")
    reads = []

    async def refuse(scene: SceneRef) -> None:
        reads.append(scene.stamp)
        raise UserError("hall.glb: is cut off")

    monkeypatch.setattr(running.service.changed_files, "_read", refuse)
    os.utime(tmp_path / "hall.glb", (2e9, 2e9))
    assert walker.word("error", code="scene-failed")["message"] == "hall.glb: is cut off"
    walker.pose(1)
    walker.frame()
    with pytest.raises(TimeoutError):
        walker.word("error", timeout=0.5)
    assert reads == [2e18]
    assert [word["type"] for word in walker.words if word["type"] == "scene"] == []
