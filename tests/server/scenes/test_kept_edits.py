import asyncio
import json
import logging
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

import pytest
from harness import run, wait_for

from gpu.scene.edits import NO_EDITS, LightEdit, MaterialEdit, ObjectEdit, SceneEdits
from gpu.scene.import_options import ImportOptions
from gpu.scene.parts import LightForm
from server.refusals import UnknownSceneError
from server.scenes.kept_edits import ASIDE, FILE, KeptEdits
from server.scenes.scene_edits import EditedScenes
from server.settings import ServerSettings
from server.wire.browser import Bounds, LightInfo, MaterialInfo, SceneInfo, ScenePatch
from server.wire.worker import SceneRef

LAMP = LightInfo(id="lamp", form=LightForm.SURFACE, color=(1.0, 1.0, 1.0))
INFO = SceneInfo(
    id="hall", name="hall", cameras=(), bounds=Bounds(min=(0, 0, 0), max=(1, 1, 1)), lights=(LAMP,), triangles=1
)
OFF = ScenePatch(lights={"lamp": LightEdit(on=False)})
EDITS = SceneEdits(lights={"lamp": LightEdit(on=False)})


def find(scene_id: str, options: ImportOptions) -> SceneRef:
    """A scene of any id, but for one."""
    if scene_id == "away.glb":
        raise UnknownSceneError("no such scene")
    return SceneRef(scene_id, f"/scenes/{scene_id}", stamp=7, options=options)


def changed(folder: Path, *ids: str) -> EditedScenes:
    """A service in whose run these scenes were edited, which it keeps in the folder."""
    edited = EditedScenes()
    kept = KeptEdits(folder, edited, find)

    async def life() -> None:
        running = asyncio.create_task(kept.run())
        await asyncio.sleep(0)
        for one in ids:
            edited.change(find(one, ImportOptions()), INFO, OFF)
        running.cancel()
        await asyncio.wait([running])

    asyncio.run(life())
    return edited


def restored(folder: Path) -> EditedScenes:
    edited = EditedScenes()
    KeptEdits(folder, edited, find)
    return edited


def test_edits_outlast_the_service(tmp_path: Path) -> None:
    changed(tmp_path, "hall.glb", "house.glb")
    scenes = restored(tmp_path).all
    assert [(scene.id, scene.stamp) for scene in scenes] == [("hall.glb", 7), ("house.glb", 7)]
    assert [*scenes.values()] == [EDITS, EDITS]
    assert [file.name for file in tmp_path.iterdir()] == [FILE]


def test_nothing_is_written_where_nothing_changes(tmp_path: Path) -> None:
    changed(tmp_path)
    assert [*tmp_path.iterdir()] == []


def test_edits_of_scenes_that_are_away_for_a_run_are_there_in_the_next(tmp_path: Path) -> None:
    away = {"scene": "away.glb", "stamp": 7, "options": {}, "edits": {"time": 1.0}}
    (tmp_path / FILE).write_text(json.dumps(away) + "\n")
    changed(tmp_path, "hall.glb")
    lines = [json.loads(line) for line in (tmp_path / FILE).read_text().splitlines()]
    assert [line["scene"] for line in lines] == ["away.glb", "hall.glb"]
    assert lines[0] == away


def test_another_upload_of_a_name_has_no_edits_of_the_one_before(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / FILE).write_text('{"scene": "uploads/hall.glb", "stamp": 6, "options": {}, "edits": {"time": 1.0}}\n')
    assert restored(tmp_path).all == {}
    assert "the file of 'uploads/hall.glb' is another one now: its edits are not taken up" in caplog.text


def test_a_file_that_was_changed_meanwhile_takes_its_edits_over(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(
        '{"scene": "hall.glb", "stamp": 6, "options": {}, "edits": {"lights": {"lamp": {"on": false}}}}\n'
    )
    edited, hall = restored(tmp_path), find("hall.glb", ImportOptions())
    assert edited.of(hall) == NO_EDITS
    edited.learn(hall, INFO)
    assert edited.all == {hall: EDITS}


def test_a_file_that_an_older_one_has_replaced_meanwhile_takes_its_edits_over(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(
        '{"scene": "hall.glb", "stamp": 9, "options": {}, "edits": {"lights": {"lamp": {"on": false}}}}\n'
    )
    edited, hall = restored(tmp_path), find("hall.glb", ImportOptions())
    edited.learn(hall, INFO)
    assert edited.all == {hall: EDITS}


def test_what_could_be_read_is_kept_where_something_else_was_set_aside(tmp_path: Path) -> None:
    changed(tmp_path, "hall.glb")
    with (tmp_path / FILE).open("ab") as file:
        file.write(b"{\n")
    changed(tmp_path)
    assert (tmp_path / (FILE + ASIDE)).exists()
    assert restored(tmp_path).all == {find("hall.glb", ImportOptions()): EDITS}


def test_a_change_whose_writing_was_still_to_begin_is_written_in_the_end(tmp_path: Path) -> None:
    edited, hall, busy = EditedScenes(), find("hall.glb", ImportOptions()), Event()
    kept = KeptEdits(tmp_path, edited, find)

    async def life() -> None:
        threads = ThreadPoolExecutor(1)
        asyncio.get_running_loop().set_default_executor(threads)
        threads.submit(busy.wait)
        running = asyncio.create_task(kept.run())
        await asyncio.sleep(0)
        edited.change(hall, INFO, OFF)
        await asyncio.sleep(0.01)
        running.cancel()
        await asyncio.wait([running])
        busy.set()

    asyncio.run(life())
    assert restored(tmp_path).all == {hall: EDITS}


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        (b"{", "line 2: Invalid JSON"),
        (b'{"scene": "hall.glb"}', "line 2: stamp: Field required; options: Field required; edits: Field required"),
        (
            b'{"scene": "a.glb", "stamp": 7, "options": {}, "edits": {"lights": {"lamp": {"intensity": -1}}}}',
            "edits.lights.lamp.intensity: Input should be greater than or equal to 0",
        ),
        (b"\xff\x00", "line 2: Invalid JSON"),
    ],
)
def test_what_means_nothing_is_told_and_set_aside(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, broken: bytes, why: str
) -> None:
    changed(tmp_path, "hall.glb")
    whole = (tmp_path / FILE).read_bytes() + broken + b"\n"
    (tmp_path / FILE).write_bytes(whole)
    assert [scene.id for scene in restored(tmp_path).all] == ["hall.glb"]
    assert "cannot be read as edits of scenes" in caplog.text
    assert why in caplog.text
    assert [file.name for file in tmp_path.iterdir()] == [FILE + ASIDE]
    assert (tmp_path / (FILE + ASIDE)).read_bytes() == whole


def test_a_link_is_not_followed(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    changed(tmp_path, "hall.glb")
    (tmp_path / FILE).rename(tmp_path / "others")
    (tmp_path / FILE).symlink_to("others")
    assert restored(tmp_path).all == {}
    assert "cannot be read as edits of scenes" in caplog.text


def test_a_folder_without_room_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / f"{FILE}.unfinished").mkdir()
    changed(tmp_path, "hall.glb")
    with caplog.at_level(logging.WARNING):
        assert "edits of scenes cannot be kept" in caplog.text


def test_edits_that_do_not_fit_what_is_in_the_scene_now_end(caplog: pytest.LogCaptureFixture) -> None:
    hall, house, told = find("hall.glb", ImportOptions()), find("house.glb", ImportOptions()), []
    edited = EditedScenes()
    edited.restore({hall: SceneEdits(lights={"moon": LightEdit(on=False)}), house: EDITS})
    edited.listeners.add(told.append)
    edited.learn(hall, INFO)
    edited.learn(house, INFO)
    assert (edited.all, told) == ({house: EDITS}, [hall])
    assert "hall.glb: edits that do not fit its file any more end: lights.moon" in caplog.text


def test_all_kinds_of_edits_come_back_as_they_were(tmp_path: Path) -> None:
    info = INFO.model_copy(update={"materials": (MaterialInfo.model_construct(id="wäll/1"),)})
    edited, hall = EditedScenes(), find("hall.glb", ImportOptions(unit="mm"))
    kept = KeptEdits(tmp_path, edited, find)
    patch = {"lights": {"lamp": LightEdit(intensity=0.1)}, "materials": {"wäll/1": MaterialEdit(color=(0.1, 0.2, 0.7))}}
    edits = edited.change(hall, info, ScenePatch(**patch))  # type: ignore[arg-type]

    async def life() -> None:
        running = asyncio.create_task(kept.run())
        await asyncio.sleep(0)
        edited.change(hall, info, ScenePatch())
        while not (tmp_path / FILE).exists():  # without being asked to end
            await asyncio.sleep(0.01)
        running.cancel()
        await asyncio.wait([running])

    asyncio.run(life())
    assert restored(tmp_path).of(hall) == edits


def test_a_service_shows_what_the_one_before_it_was_told(tmp_path: Path) -> None:
    settings = ServerSettings(port=0, uploads_dir=tmp_path)
    scene = "/api/v1/scenes/cornell-box"
    with run(settings) as service:
        service.wait_ready()
        before = service.http.patch(scene, json={"objects": {"chair": {"visible": False}}})
        assert before.status_code == 200, before.text
        wait_for((tmp_path / FILE).exists)
    with run(settings) as service, service.walker() as walker:
        service.wait_ready()
        walker.hello()
        assert walker.word("edits")["edits"] == before.json()
        assert before.json()["objects"] == {"chair": ObjectEdit(visible=False).model_dump()}
        assert service.http.patch(scene, json={"objects": None}).status_code == 200
    with run(settings) as service:
        assert service.http.get(scene).json()["edits"]["objects"] == {}
