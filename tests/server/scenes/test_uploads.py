import asyncio
import io
import json
import sys
import zipfile
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest
from glb_file import TRIANGLE, TRIANGLE_GLB, triangle
from harness import ANY_CHECK

from gpu.errors import SceneError, UserError
from gpu.scene.load import SUFFIXES
from server.refusals import NoRoomError, TooLargeError, TooSlowError, UnknownSceneError
from server.scenes import uploads as module
from server.scenes.checker import CHECK, Checker
from server.scenes.uploads import ARCHIVE, Uploads, clean_name
from server.settings import ServerSettings

Make = Callable[..., Uploads]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Makes uploads in a folder that is kept, with settings of choice and a checker that takes everything."""

    def made(check: tuple[str, ...] = ANY_CHECK, **settings: Any) -> Uploads:
        chosen = ServerSettings(**{"uploads_dir": tmp_path / "uploads"} | settings)
        return Uploads(chosen, Checker(chosen, check))

    return made


def add(
    uploads: Uploads, name: str = "a.glb", content: bytes = b"content", used: frozenset[str] = frozenset()
) -> module.Upload:
    """Upload a file in two pieces."""

    async def body() -> AsyncIterator[bytes]:
        yield content[:3]
        yield content[3:]

    return asyncio.run(uploads.add(name, None, body(), used.__contains__))


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


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


def test_the_longest_unused_makes_room(make: Make) -> None:
    uploads = make(max_uploads=2)
    a, b = add(uploads, "a.glb"), add(uploads, "b.glb")
    uploads.touch(a.id)
    c = add(uploads, "c.glb")
    assert list(uploads.all) == [a.id, c.id]
    assert not uploads.path(b).exists()


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


def test_a_body_that_stalls_is_given_up(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STALL_SECONDS", 0.05)

    async def body() -> AsyncIterator[bytes]:
        yield b"abc"
        await asyncio.sleep(60)

    with pytest.raises(TooSlowError):
        asyncio.run(make().add("a.glb", None, body(), lambda _: False))
    assert files(tmp_path) == []


def test_a_body_that_drips_is_given_up(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STALL_SECONDS", 0.05)

    async def body() -> AsyncIterator[bytes]:
        while True:
            yield b"v"
            await asyncio.sleep(0.01)

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
    with pytest.raises(SceneError, match=r"^a\.gltf: buffers\[0\]\.uri: .* upload a \.glb, or a \.zip"):
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
