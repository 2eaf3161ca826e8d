"""The WebSocket as a viewer meets it: admission, messages, frames, scenes, failures."""

import asyncio
import itertools
import os
import signal
import time
from collections.abc import Callable
from math import inf
from pathlib import Path
from threading import Event, Thread

import pytest
import simplejpeg
from gradient_worker import BUG_SEED, DEADLY_SEED, LONG_SEED, SLOW_SEED, TARGET, WRONG_SEED
from harness import Running, Walker, wait_for
from websockets.exceptions import ConnectionClosed

from server.scenes import checker
from server.walk.session import Session
from server.walk.viewer import Viewer
from server.wire.browser import PROTOCOL, WINDOW, SceneInfo
from server.wire.frame_header import Codec, Phase
from server.wire.worker import SceneRef

Visit = Callable[[Running], Walker]


@pytest.fixture
def walker(running: Running, visit: Visit) -> Walker:
    """A viewer that has been welcomed and knows the scene."""
    walker = visit(running)
    walker.hello()
    return walker


def closed(walker: Walker) -> int:
    """The code with which the server closes the socket."""
    with pytest.raises(ConnectionClosed) as caught:
        walker.word("never")
    assert caught.value.rcvd is not None
    return caught.value.rcvd.code


def test_the_welcome_says_what_there_is(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36])
    welcome = walker.word("welcome")
    assert welcome["scenes"][0]["id"] == "cornell-box"
    assert welcome["run"] == running.service.run
    assert welcome["still_frames"] == {"draft": 2, "balanced": 16, "best": 64}  # of a CPU
    assert {"rooms/hall.glb", "broken.glb"} < {scene["id"] for scene in welcome["scenes"]}
    assert welcome["settings_schema"]["properties"]["fuzziness"]["maximum"] == 8
    assert welcome["limits"]["max_pixels"] == 640 * 360
    scene = walker.word("scene")
    assert scene["id"] == "cornell-box"
    assert scene["cameras"][0]["name"] == "front"
    walker.word("status", state="ready")


def test_frames_are_not_compressed_again(walker: Walker) -> None:
    assert walker.socket.protocol.extensions == []


def test_a_pose_brings_its_frame(walker: Walker) -> None:
    walker.pose(41, x=1.0)
    header, image = walker.frame()
    assert (header.pose, header.frame, header.settings) == (41, 1, 0)
    assert header.render_ms > 0.0
    assert header.encode_ms > 0.0
    assert header.queue_ms >= 0.0
    assert header.stage_ms == {"gbuffer": 0.5, "shade": 1.5, "extra": 2.0}
    pixels = simplejpeg.decode_jpeg(image)
    assert pixels.shape == (36, 64, 3)
    assert abs(float(pixels[..., 1].mean()) - 255.0) < 8.0


def test_a_view_that_rests_gets_sharper_and_then_nothing_comes(walker: Walker) -> None:
    walker.pose(1)
    headers = []
    while not headers or headers[-1].phase is not Phase.FINAL:
        headers.append(walker.frame()[0])
        walker.send("ack", frame=headers[-1].frame)
    assert [header.phase for header in headers] == [Phase.MOVING, Phase.STILL, Phase.STILL, Phase.FINAL]
    assert [header.samples for header in headers] == [1, 1, 2, TARGET]
    assert [header.target_samples for header in headers[1:]] == [TARGET] * 3
    assert headers[1].quality > headers[0].quality
    walker.no_frame()


def test_the_final_frame_is_lossless_when_wanted(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36], codecs=["png", "jpeg"], stream={"lossless": True})
    assert set(walker.word("welcome")["codecs"]) == {"jpeg", "png"}
    walker.word("scene")
    walker.pose(1)
    while True:
        header, image = walker.frame()
        walker.send("ack", frame=header.frame)
        if header.phase is Phase.FINAL:
            break
        assert header.codec is Codec.JPEG
    assert (header.codec, header.quality) == (Codec.PNG, 100)
    assert image.startswith(b"\x89PNG")


def test_moving_frames_are_video_when_wanted(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[64, 36], codecs=["jpeg", "h264"], stream={"video": True})
    assert set(walker.word("welcome")["codecs"]) == {"jpeg", "h264"}
    walker.word("scene")
    codecs = []
    for number, broken in ((1, False), (2, True), (3, False)):
        walker.pose(number)
        while (frame := walker.frame())[0].phase is not Phase.MOVING:  # it may have rested meanwhile
            walker.send("ack", frame=frame[0].frame)
        header, image = frame
        assert image.startswith(b"\0\0\0\1")
        codecs.append(header.codec)
        walker.send("ack", frame=header.frame, broken=broken)
    assert codecs == [Codec.H264_KEY, Codec.H264, Codec.H264_KEY]


def test_moving_frames_have_the_scale_that_is_locked(walker: Walker) -> None:
    walker.send("settings", id=1, size=[256, 144], stream={"motion_scale": 0.5})
    walker.pose(1)
    header = walker.frame()[0]
    assert (header.phase, header.width, header.height) == (Phase.MOVING, 128, 72)


def test_the_newest_pose_wins(running: Running, walker: Walker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.watch.HEARTBEAT_SECONDS", inf)  # they would have the turn
    (engine,) = running.service.engines.engines
    wait_for(lambda: len(engine._jobs.running) == 0)
    worker = engine.worker_pid
    assert worker is not None
    os.kill(worker, signal.SIGSTOP)
    try:
        walker.pose(1)
        wait_for(lambda: any(not turn.is_heartbeat for turn in engine._jobs.running))
        for number in range(2, 30):
            walker.pose(number)
        walker.socket.send("{")  # an error tells that what came before it was read
        walker.word("error", code="bad-message")
    finally:
        os.kill(worker, signal.SIGCONT)
    poses = []
    for _ in range(2):
        header, _ = walker.frame()
        walker.send("ack", frame=header.frame)
        poses.append(header.pose)
    assert poses == [1, 29]


def test_at_most_a_window_of_frames_is_unacknowledged(walker: Walker) -> None:
    for number in range(1, 20):
        walker.pose(number)
        time.sleep(0.01)
    frames = [walker.frame()[0].frame for _ in range(WINDOW)]
    walker.no_frame()
    walker.send("ack", frame=frames[-1])
    assert walker.frame()[0].pose == 19


def test_settings_change_the_frames(walker: Walker) -> None:
    walker.pose(3)
    walker.send("ack", frame=walker.frame()[0].frame)
    walker.send("settings", id=9, size=[32, 18], settings={"method": "path"})
    while (header := (frame := walker.frame())[0]).settings != 9:  # the last view may have come to rest before
        walker.send("ack", frame=header.frame)
    image = frame[1]
    assert (header.pose, header.settings, header.width, header.height) == (3, 9, 32, 18)
    assert simplejpeg.decode_jpeg_header(image)[:2] == (18, 32)


def test_each_viewer_has_its_own_camera(running: Running, visit: Visit) -> None:
    walkers = [visit(running) for _ in range(2)]
    for index, walker in enumerate(walkers):
        walker.hello()
        walker.pose(index + 1, x=float(index))
    green = [float(simplejpeg.decode_jpeg(walker.frame()[1])[..., 1].mean()) for walker in walkers]
    assert green == pytest.approx([0.0, 255.0], abs=8.0)


def test_viewers_take_turns(running: Running, visit: Visit) -> None:
    walkers = [visit(running) for _ in range(2)]
    counts = [0, 0]
    for walker in walkers:
        walker.hello()
        walker.send("settings", id=1, settings={"seed": SLOW_SEED})
    for number in range(1, 4):
        for index, walker in enumerate(walkers):
            walker.pose(number)
            if number > 1:
                walker.send("ack", frame=walker.frame()[0].frame)
                counts[index] += 1
    assert counts == [2, 2]


def test_another_scene_needs_another_pose(walker: Walker) -> None:
    walker.pose(1)
    walker.send("ack", frame=walker.frame()[0].frame)
    walker.send("settings", id=1, scene="rooms/hall.glb")
    assert walker.word("scene")["id"] == "rooms/hall.glb"
    for late, _ in walker.frames:  # a still frame of the other scene may have been on its way
        walker.send("ack", frame=late.frame)
    walker.frames.clear()
    walker.no_frame()
    walker.pose(2)
    assert walker.frame()[0].settings == 1


def test_a_scene_read_otherwise_needs_another_pose(walker: Walker) -> None:
    walker.send("settings", id=1, scene="rooms/hall.glb")
    walker.word("scene")
    walker.send("settings", id=2, scene_options={"unit": "mm", "up": "z"})
    scene = walker.word("scene")
    assert (scene["id"], scene["options"]["unit"], scene["options"]["up"]) == ("rooms/hall.glb", "mm", "z")
    walker.pose(1)
    assert walker.frame()[0].settings == 2
    walker.send("settings", id=3, scene="rooms/hall.glb")
    assert walker.word("scene")["options"]["unit"] is None


def test_a_scene_that_cannot_be_opened_leaves_the_last_one(walker: Walker) -> None:
    walker.send("settings", id=1, scene="broken.glb")
    assert "accessors[0]" in walker.word("error", code="scene-failed")["message"]
    assert walker.word("scene")["id"] == "cornell-box"
    walker.pose(1)
    walker.frame()


def test_why_a_scene_cannot_be_opened_is_not_told_to_who_has_chosen_another(
    walker: Walker, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = Viewer._read

    async def reads_long(viewer: Viewer, scene: SceneRef) -> SceneInfo:
        while scene.id == "broken.glb" and viewer._wanted == scene:
            await asyncio.sleep(0.01)
        return await read(viewer, scene)

    monkeypatch.setattr(Viewer, "_read", reads_long)
    walker.send("settings", id=1, scene="broken.glb")
    walker.word("status", state="loading")
    walker.send("settings", id=2, scene="rooms/hall.glb")
    while not (scenes := [word["id"] for word in walker.words if word["type"] == "scene"]):
        walker.no_frame()
    assert scenes == ["rooms/hall.glb"]
    assert [word for word in walker.words if word["type"] == "error"] == []


@pytest.mark.parametrize("scene", ["nowhere", "../conftest.py", "/etc/passwd", "rooms/../broken.glb"])
def test_an_unknown_scene_is_refused(walker: Walker, scene: str) -> None:
    walker.send("settings", id=1, scene=scene)
    assert scene in walker.word("error", code="unknown-scene")["message"]


def test_an_unknown_scene_in_the_hello_gives_the_served_one(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[8, 8], scene="gone")
    walker.word("error", code="unknown-scene")
    assert walker.word("scene")["id"] == "cornell-box"


@pytest.mark.parametrize(
    "message",
    ["{", '{"type":"ack","frame":99}', '{"type":"pose","id":1}', '{"type":"hello","protocol":1,"size":[8,8]}', b"\x00"],
)
def test_a_wrong_message_is_refused_and_the_session_goes_on(walker: Walker, message: str | bytes) -> None:
    walker.socket.send(message)
    walker.word("error", code="bad-message")
    walker.pose(1)
    walker.frame()


@pytest.mark.parametrize("change", [{"size": [640, 361]}, {"settings": {"samples": 65}}])
def test_settings_beyond_the_limits_are_refused(walker: Walker, change: dict[str, object]) -> None:
    walker.send("settings", id=1, **change)
    walker.word("error", code="limit")
    walker.pose(1)
    assert walker.frame()[0].settings == 0


def test_a_hello_beyond_the_limits_is_refused(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.send("hello", protocol=PROTOCOL, size=[640, 361])
    walker.word("error", code="limit")
    assert closed(walker) == 1008


def test_a_session_starts_with_hello(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.pose(1)
    assert "first message must be hello" in walker.word("error", code="bad-message")["message"]
    assert closed(walker) == 1002


def test_a_message_that_is_too_big_closes_the_session(running: Running, walker: Walker) -> None:
    walker.socket.send("x" * (running.service.settings.max_message_bytes + 1))
    assert closed(walker) == 1009


def test_one_viewer_too_many_is_told_to_try_again(running: Running, visit: Visit) -> None:
    wait_for(lambda: not running.service.viewers)  # those of other tests are leaving
    for _ in range(running.service.settings.max_viewers):
        visit(running).hello()
    assert closed(visit(running)) == 1013


def test_a_render_that_fails_is_reported_once(walker: Walker) -> None:
    walker.send("settings", id=1, settings={"seed": WRONG_SEED})
    for number in (1, 2, 3):
        walker.pose(number)
    assert walker.word("error", code="render-failed")["message"] == "settings.seed: is the wrong one"
    with pytest.raises(TimeoutError):
        walker.word("error", timeout=0.3)
    walker.send("settings", id=2, settings={})
    assert walker.frame()[0].pose == 3


def test_a_bug_is_reported_without_its_traceback(walker: Walker) -> None:
    walker.send("settings", id=1, settings={"seed": BUG_SEED})
    walker.pose(1)
    message = walker.word("error", code="render-failed")["message"]
    assert "internal error" in message
    assert "Traceback" not in message


def test_a_killed_worker_is_replaced_and_the_viewer_stays(serve: Callable[..., Running], visit: Visit) -> None:
    running = serve()
    walker = visit(running)
    walker.hello()
    walker.pose(1)
    walker.send("ack", frame=walker.frame()[0].frame)
    pid = running.service.engines.engines[0].worker_pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    walker.word("status", state="recovering")
    walker.pose(2, x=0.5)
    walker.word("status", state="ready")
    assert walker.frame()[0].pose == 2


def test_a_view_that_kills_the_worker_is_given_up(serve: Callable[..., Running], visit: Visit) -> None:
    walker = visit(serve())
    walker.hello()
    walker.send("settings", id=1, settings={"seed": DEADLY_SEED})
    walker.pose(1)
    assert "change it" in walker.word("error", code="render-failed")["message"]
    walker.send("settings", id=2, settings={})
    assert walker.frame()[0].settings == 2


def test_a_scene_that_kills_the_worker_is_given_up(serve: Callable[..., Running], visit: Visit, tmp_path: Path) -> None:
    (tmp_path / "deadly.glb").write_bytes(b"")
    walker = visit(serve(scenes_dir=tmp_path))
    walker.hello()
    walker.send("settings", id=1, scene="deadly.glb")
    walker.word("error", code="scene-failed")
    assert walker.word("scene")["id"] == "cornell-box"
    walker.pose(1)
    walker.frame()


def test_who_starts_to_walk_does_not_wait_behind_walkers_for_a_sharper_picture(
    serve: Callable[..., Running], visit: Visit
) -> None:
    running = serve()
    resting, *walking = (visit(running) for _ in range(3))
    for walker in (resting, *walking):
        walker.hello(settings={"seed": SLOW_SEED, "frames": 1000})
    ended = Event()

    def walk(walker: Walker) -> None:  # so that one of them waits all the time
        for number in itertools.count(1):
            walker.pose(number)
            walker.send("ack", frame=walker.frame()[0].frame)
            if ended.is_set():
                return

    resting.pose(1)
    while resting.frame()[0].phase is Phase.MOVING:
        pass
    threads = [Thread(target=walk, args=(walker,)) for walker in walking]
    for thread in threads:
        thread.start()
    try:
        time.sleep(1.0)  # until a sharper picture waits
        resting.send("ack", frame=2)
        resting.pose(2)
        while resting.frame()[0].pose != 2:
            pass
    finally:
        ended.set()
        for thread in threads:
            thread.join()


def test_a_view_that_gets_sharper_is_ready(walker: Walker) -> None:
    walker.send("settings", id=1, settings={"seed": LONG_SEED, "frames": 2})
    walker.pose(1)
    walker.word("status", state="loading", text="long")
    while (header := walker.frame()[0]).phase is Phase.MOVING:
        walker.send("ack", frame=header.frame)
    walker.send("ack", frame=header.frame)
    # What told that it was loading has passed; that it is ready may have come before the picture.
    loading = [place for place, word in enumerate(walker.words) if word.get("state") == "loading"]
    del walker.words[: max(loading, default=-1) + 1]
    walker.word("status", state="ready")
    assert walker.frame()[0].phase is Phase.FINAL
    assert not [word for word in walker.words if word["type"] == "status" and word["state"] != "ready"]


def test_the_served_file_may_be_gone(serve: Callable[..., Running], visit: Visit, tmp_path: Path) -> None:
    file = tmp_path / "hall.glb"
    file.write_bytes(b"")
    walker = visit(serve(scene=str(file)))
    file.unlink()
    walker.send("hello", protocol=PROTOCOL, size=[8, 8])
    walker.word("error", code="unknown-scene")
    walker.send("settings", id=1, scene="cornell-box")
    assert walker.word("scene")["id"] == "cornell-box"


def test_a_busy_checker_does_not_end_the_session(
    serve: Callable[..., Running], visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checker, "MAX_WAITING", 0)
    (tmp_path / "hall.glb").write_bytes(b"")
    walker = visit(serve(scenes_dir=tmp_path))
    walker.hello()
    walker.send("settings", id=1, scene="hall.glb")
    assert "try again" in walker.word("error", code="scene-failed")["message"]
    assert walker.word("scene")["id"] == "cornell-box"


def test_a_fault_of_the_web_process_is_said_and_logged(
    running: Running, walker: Walker, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(Session, "pose", lambda *_: 1 / 0)
    walker.pose(1)
    assert closed(walker) == 1011
    assert "ZeroDivisionError" in caplog.text
    assert running.service.metrics.registry.get_sample_value("lumenwalk_dropped_total", {"reason": "fault"}) == 1


def test_viewers_of_a_service_that_starts_see_its_progress(serve: Callable[..., Running], visit: Visit) -> None:
    walker = visit(serve(ready=False))
    walker.send("hello", protocol=PROTOCOL, size=[8, 8])
    walker.word("status", state="loading")
    walker.word("scene")


def test_a_viewer_that_leaves_is_forgotten(running: Running) -> None:
    with running.walker() as walker:
        walker.hello()
        here, listeners = set(running.service.viewers), len(running.service.engines.listeners)
    wait_for(lambda: not running.service.viewers.keys() >= here)
    wait_for(lambda: len(running.service.engines.listeners) < listeners)
