import asyncio
import io
import json
import logging
import os
import shutil
import sys
import time
import zipfile
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from glb_file import TRIANGLE, TRIANGLE_GLB, triangle
from harness import ANY_CHECK

from gpu.errors import SceneError, UserError
from gpu.scene.load import SUFFIXES
from server.folders import LOCK
from server.places import asker
from server.refusals import NoRoomError, TooLargeError, TooSlowError, UnknownSceneError
from server.scenes import uploads as module
from server.scenes.checker import CHECK, Checker
from server.scenes.upload_records import Upload
from server.scenes.uploads import ARCHIVE, Uploads, clean_name
from server.settings import ServerSettings

Make = Callable[..., Uploads]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Makes uploads in a folder that is kept, with settings of choice and a checker that takes everything.

    Each ends the one before, as two cannot have one folder.
    """
    all_made: list[Uploads] = []

    def made(check: tuple[str, ...] = ANY_CHECK, **settings: Any) -> Uploads:
        chosen = ServerSettings(**{"uploads_dir": tmp_path / "uploads"} | settings)
        for before in all_made:
            before.close()
        all_made.append(Uploads(chosen, Checker(chosen, check)))
        return all_made[-1]

    yield made
    for each in all_made:
        each.close()


def add(
    uploads: Uploads, name: str = "a.glb", content: bytes = b"content", used: frozenset[str] = frozenset()
) -> Upload:
    """Upload a file in two pieces."""

    async def body() -> AsyncIterator[bytes]:
        yield content[:3]
        yield content[3:]

    return asyncio.run(uploads.add(name, None, body(), used.__contains__))


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file() and path.name != LOCK)


@pytest.mark.parametrize(
    ("name", "stem", "suffix"),
    [
        ("house.glb", "house", ".glb"),
        ("House of cards.GLB", "House of cards", ".glb"),
        ("../../etc/passwd.glb", "passwd", ".glb"),
        ("C:\\models\\house.obj", "house", ".obj"),
        ("a<b>&\"'\n;.ply", "a-b------", ".ply"),
        ("...glb.glb", "glb", ".glb"),
        (".hidden.stl", "hidden", ".stl"),
        ("Ünïcode❤♻Test.zip", "Ünïcode--Test", ".zip"),
        ("?.glb", "-", ".glb"),
        (" .glb", "scene", ".glb"),
        ("x" * 500 + ".off", "x" * 64, ".off"),
    ],
)
def test_a_name_becomes_a_safe_stem_and_a_suffix(name: str, stem: str, suffix: str) -> None:
    assert clean_name(name) == (stem, suffix)


@pytest.mark.parametrize("name", ["", "house", "house.exe", ".glb", "house.glb.exe"])
def test_a_name_that_is_no_scene_is_refused(name: str) -> None:
    with pytest.raises(SceneError, match=r"upload one of \.glb"):
        clean_name(name)


def test_a_file_is_kept_in_a_folder_of_its_own(make: Make) -> None:
    uploads = make()
    first, second = add(uploads), add(uploads)
    assert [first.id, second.id] == ["uploads/a.glb", "uploads/a-2.glb"]
    assert add(uploads, "export.glb").id == "uploads/export-2.glb"  # whose address would be that of a download
    assert uploads.path(first).read_bytes() == b"content"
    assert uploads.path(first).parent != uploads.path(second).parent
    assert first.bytes == len(b"content")


def test_uploads_are_found_again(make: Make, tmp_path: Path) -> None:
    upload = add(make())
    (tmp_path / "uploads" / ".upload-unfinished").mkdir()
    (tmp_path / "uploads" / "broken.upload.json").write_text("{")
    again = make()
    assert again.all == {upload.id: upload}
    assert not (tmp_path / "uploads" / ".upload-unfinished").exists()


def test_a_record_that_claims_all_room_makes_none_for_itself(make: Make, tmp_path: Path) -> None:
    upload = add(make())
    (record,) = (tmp_path / "uploads").glob("*.upload.json")
    record.write_text(upload.model_copy(update={"bytes": 10**18}).model_dump_json())
    assert make().all == {upload.id: upload}


def test_a_removed_upload_leaves_nothing(make: Make, tmp_path: Path) -> None:
    uploads = make()
    asyncio.run(uploads.remove(add(uploads).id))
    assert (uploads.all, files(tmp_path)) == ({}, [])
    with pytest.raises(UnknownSceneError):
        asyncio.run(uploads.remove("uploads/a.glb"))


def test_a_file_that_is_too_large_is_not_kept(make: Make, tmp_path: Path) -> None:
    uploads = make(max_upload_bytes=2000)
    with pytest.raises(TooLargeError, match="2000 bytes"):
        add(uploads, content=bytes(2001))
    assert files(tmp_path) == []


def test_a_file_that_is_not_sound_is_not_kept(make: Make, tmp_path: Path) -> None:
    uploads = make(CHECK)
    with pytest.raises(SceneError, match=r"^a\.glb: "):
        add(uploads, content=TRIANGLE_GLB[:60])
    assert (uploads.all, files(tmp_path)) == ({}, [])


def test_the_longest_unused_makes_room_and_the_log_tells(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    uploads = make(max_uploads=2)
    a, b = add(uploads, "a.glb"), add(uploads, "b.glb")
    uploads.touch(a.id)
    with caplog.at_level(logging.INFO):
        c = add(uploads, "c.glb")
    told = [(record.getMessage(), vars(record)["scene"]) for record in caplog.records]
    assert told == [("upload deleted: another one needs its room", b.id), ("upload kept", c.id)]
    assert list(uploads.all) == [a.id, c.id]
    assert not uploads.path(b).exists()


def test_what_the_folder_cannot_take_is_told_by_the_log_too(
    make: Make, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    uploads = make()
    shutil.rmtree(tmp_path / "uploads")
    (tmp_path / "uploads").touch()
    with pytest.raises(NoRoomError, match=r"a\.glb: cannot be kept: Not a directory"):
        add(uploads)
    assert f"an upload cannot be kept in {tmp_path}/uploads: Not a directory" in caplog.text


def test_bytes_make_room_too(make: Make) -> None:
    uploads = make(max_uploads_bytes=2000)
    add(uploads, "a.glb", bytes(1200))
    assert list(make(max_uploads_bytes=2000).all) == ["uploads/a.glb"]
    add(uploads, "b.glb", bytes(1200))
    assert list(uploads.all) == ["uploads/b.glb"]


def test_what_is_used_does_not_make_room(make: Make, tmp_path: Path) -> None:
    uploads = make(max_uploads=1)
    a = add(uploads, "a.glb")
    with pytest.raises(NoRoomError, match="1 scenes"):
        add(uploads, "b.glb", used=frozenset({a.id}))
    assert list(uploads.all) == [a.id]
    assert len(files(tmp_path)) == 2


def test_what_somebody_comes_to_use_while_room_is_made_stays(make: Make) -> None:
    uploads = make(max_uploads_bytes=2000)
    a, b = add(uploads, "a.glb", bytes(900)), add(uploads, "b.glb", bytes(900))

    async def body() -> AsyncIterator[bytes]:
        yield bytes(1900)

    with pytest.raises(NoRoomError, match="2000 bytes"):
        asyncio.run(uploads.add("c.glb", None, body(), lambda id_: id_ == b.id and a.id not in uploads.all))
    assert list(uploads.all) == [b.id]


def test_a_body_that_stalls_is_given_up(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STALL_SECONDS", 0.05)

    async def body() -> AsyncIterator[bytes]:
        yield b"abc"
        await asyncio.sleep(60)

    with pytest.raises(TooSlowError):
        asyncio.run(make().add("a.glb", None, body(), lambda _: False))
    assert files(tmp_path) == []


def test_a_body_that_drips_is_given_up(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(module, "monotonic", lambda: now[0])

    async def body() -> AsyncIterator[bytes]:
        while True:
            yield b"v"
            now[0] += 0.9 * module.STALL_SECONDS

    with pytest.raises(TooSlowError, match="bytes a second"):
        asyncio.run(make().add("a.obj", None, body(), lambda _: False))
    assert files(tmp_path) == []


def test_an_archive_becomes_its_scene(make: Make) -> None:
    uploads = make(CHECK)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("model/house.gltf", json.dumps(triangle(buffers=[{"byteLength": 36, "uri": "a.bin"}])))
        archive.writestr("model/a.bin", TRIANGLE)
    upload = add(uploads, "villa.zip", packed.getvalue())
    assert upload.id == "uploads/villa.gltf"
    assert upload.checked.info.triangles == 1
    assert uploads.path(upload).name == "house.gltf"
    assert make().all == {upload.id: upload}


def test_a_lone_gltf_is_told_how_to_bring_its_files(make: Make) -> None:
    content = json.dumps(triangle(buffers=[{"byteLength": 36, "uri": "a.bin"}])).encode()
    with pytest.raises(SceneError, match=r"^a\.gltf: buffers\[0\]\.uri: .* upload a \.glb, a \.zip"):
        add(make(CHECK), "a.gltf", content)


def test_a_folder_that_cannot_be_used_is_said(make: Make, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot keep uploads there"):
        make(uploads_dir=tmp_path / "file" / "uploads")


def test_a_checker_that_crashes_leaves_nothing(make: Make, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="SIGABRT"):
        add(make((sys.executable, "-c", "import os; os.abort()")))
    assert files(tmp_path) == []


def test_the_page_offers_files_of_every_format() -> None:
    page = (Path(__file__).parents[3] / "web" / "index.html").read_text()
    assert f'accept="{",".join((*SUFFIXES, ARCHIVE))}"' in page


def test_a_folder_has_one_service(make: Make, tmp_path: Path) -> None:
    make()
    chosen = ServerSettings(uploads_dir=tmp_path / "uploads")
    with pytest.raises(UserError, match="another service keeps its uploads there"):
        Uploads(chosen, Checker(chosen, ANY_CHECK))
    make().close()
    Uploads(chosen, Checker(chosen, ANY_CHECK)).close()


class Rising:
    """A body that comes in pieces and looks at what lies in the folder meanwhile."""

    def __init__(self, folder: Path, content: bytes) -> None:
        self.folder, self.content, self.most = folder, content, 0

    async def __aiter__(self) -> AsyncIterator[bytes]:
        for at in range(0, len(self.content), module.CHUNK_BYTES):
            yield self.content[at : at + module.CHUNK_BYTES]
            self.most = max(self.most, sum(path.stat().st_size for path in self.folder.rglob("*") if path.is_file()))
            await asyncio.sleep(0)


def test_the_limit_of_all_holds_while_files_come(make: Make, tmp_path: Path) -> None:
    most = 4 * module.CHUNK_BYTES
    uploads = make(max_uploads_bytes=most)
    bodies = [Rising(tmp_path, bytes(3 * module.CHUNK_BYTES)) for _ in range(4)]

    async def crowd() -> list[Upload | BaseException]:
        adding = (uploads.add(f"{n}.glb", None, aiter(body), lambda _: False) for n, body in enumerate(bodies))
        return await asyncio.gather(*adding, return_exceptions=True)

    results = asyncio.run(crowd())
    assert {type(result) for result in results} <= {Upload, NoRoomError}
    assert 0 < max(body.most for body in bodies) <= most
    assert uploads._claims == {}
    assert add(uploads, "z.glb", bytes(most)).bytes == most


def packed(*sizes: int) -> bytes:
    """An archive of a scene and files of these sizes that pack well."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.glb", TRIANGLE_GLB)
        archive.writestr("noise", os.urandom(2000))
        for number, size in enumerate(sizes):
            archive.writestr(f"{number}.bin", bytes(size))
    return content.getvalue()


def test_an_archive_makes_room_for_what_it_holds_and_no_more_than_there_is(make: Make) -> None:
    uploads = make(CHECK, max_uploads_bytes=100_000)
    older = add(uploads, "old.glb", TRIANGLE_GLB)
    kept = add(uploads, "a.zip", packed(80_000))
    assert kept.bytes > 80_000
    assert list(uploads.all) == [older.id, kept.id]
    newer = add(uploads, "b.zip", packed(60_000))
    assert list(uploads.all) == [newer.id]
    with pytest.raises(SceneError, match=r"bytes unpacked, more than the \d+ allowed"):
        add(uploads, "c.zip", packed(110_000))
    assert list(uploads.all) == [newer.id]
    assert uploads._claims == {}


def test_who_leaves_as_a_refused_file_is_deleted_takes_no_room(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    uploads, deleting, delete = make((sys.executable, "-c", "raise SystemExit(3)")), Event(), module.shutil.rmtree

    def delete_slowly(path: Path, **more: Any) -> None:
        deleting.set()
        time.sleep(0.2)
        delete(path, **more)

    async def body() -> AsyncIterator[bytes]:
        yield b"content"

    async def run() -> None:
        task = asyncio.create_task(uploads.add("a.glb", None, body(), lambda _: False))
        await asyncio.to_thread(deleting.wait, 20)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert uploads._taken == 0

    monkeypatch.setattr(module.shutil, "rmtree", delete_slowly)
    asyncio.run(run())


def test_of_one_client_one_file_is_read_at_a_time(
    make: Callable[..., Uploads], monkeypatch: pytest.MonkeyPatch
) -> None:
    uploads = make()
    check, readings, most = uploads._checker.check, Counter[str](), Counter[str]()

    async def counted(source: str, name: str, *rest: Any, **more: Any) -> Any:
        readings[name] += 1
        most[name] = max(most[name], readings[name])
        most["all"] = max(most["all"], readings.total())
        try:
            return await check(source, name, *rest, **more)
        finally:
            readings[name] -= 1

    async def body() -> AsyncIterator[bytes]:
        yield b"content"

    async def upload(client: str) -> None:
        asker.set(client)
        await uploads.add(f"{client}.glb", None, body(), lambda _: False)

    async def run() -> None:
        await asyncio.gather(*(upload(client) for client in "ab" for _ in range(3)))

    monkeypatch.setattr(uploads._checker, "check", counted)
    asyncio.run(run())
    assert most == {"a.glb": 1, "b.glb": 1, "all": 2}
