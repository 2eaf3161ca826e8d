import asyncio
import os
import time
from pathlib import Path
from threading import Event, get_ident

import pytest
from harness import PATIENCE

from gpu.errors import UserError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from server.refusals import UnknownSceneError
from server.scenes.catalogue import NAMED, Catalogue
from server.wire.worker import SceneRef


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scenes folder beside a file that is not in it."""
    (tmp_path / "outside.glb").write_bytes(b"")
    folder = tmp_path / "scenes"
    (folder / "deep" / "__MACOSX").mkdir(parents=True)
    for name in ("a.glb", "deep/b.gltf", "deep/c.OBJ", "texture.png", "deep/._b.gltf", "deep/__MACOSX/d.glb"):
        (folder / name).write_bytes(b"")
    (folder / "link.glb").symlink_to(tmp_path / "outside.glb")
    return folder


def test_the_served_scene_comes_first_then_built_in_ones_then_files(folder: Path) -> None:
    names = Catalogue("living-room", folder).names()
    assert (names[0].id, names[0].served, names[0].builtin) == ("living-room", True, True)
    assert [name.id for name in names if name.served] == ["living-room"]
    assert [name.id for name in names if not name.builtin] == ["a.glb", "deep/b.gltf", "deep/c.OBJ"]
    assert "cornell-box" in [name.id for name in names]


def test_a_link_that_leads_out_of_the_folder_is_not_a_scene(folder: Path) -> None:
    with pytest.raises(UnknownSceneError):
        Catalogue("cornell-box", folder).find("link.glb")


@pytest.mark.parametrize("scene_id", ["../outside.glb", "/etc/passwd", "deep/../a.glb", "texture.png", ""])
def test_an_id_is_never_a_path(folder: Path, scene_id: str) -> None:
    with pytest.raises(UnknownSceneError):
        Catalogue("cornell-box", folder).find(scene_id)


def test_who_asks_for_a_scene_that_is_not_there_hears_of_some_that_are(folder: Path) -> None:
    catalogue = Catalogue("cornell-box", folder)
    first, *others = [name.id for name in catalogue.names()]
    with pytest.raises(UnknownSceneError) as told:
        catalogue.find("gone.glb")
    words = f"scene: there is no 'gone.glb' here, but {first}, {others[0]}, "
    assert str(told.value).startswith(words)
    assert str(told.value).endswith(f" and {1 + len(others) - NAMED} more")


def test_a_served_file_has_its_name_for_id(folder: Path, tmp_path: Path) -> None:
    served = str(tmp_path / "outside.glb")
    catalogue = Catalogue(served, folder)
    assert catalogue.served.source == served
    assert catalogue.find("outside.glb") == catalogue.served


def test_a_file_that_changed_is_another_scene_to_the_worker(folder: Path) -> None:
    catalogue = Catalogue("cornell-box", folder)
    before = catalogue.find("a.glb")
    os.utime(folder / "a.glb", ns=(1, 1))
    after = catalogue.find("a.glb")
    assert (before.id, before.source) == (after.id, after.source)
    assert before != after


def test_a_file_that_was_removed_is_unknown(folder: Path) -> None:
    catalogue = Catalogue("cornell-box", folder)
    catalogue.find("a.glb")
    (folder / "a.glb").unlink()
    with pytest.raises(UnknownSceneError, match=r"a\.glb"):
        catalogue.find("a.glb")


def test_built_in_scenes_are_found_by_name() -> None:
    assert Catalogue("cornell-box", None).find("atrium") == SceneRef("atrium", "atrium")


def test_what_does_not_exist_is_not_served(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no such file"):
        Catalogue(str(tmp_path / "gone.glb"), None)
    with pytest.raises(UserError, match="no such folder of scenes"):
        Catalogue("cornell-box", tmp_path / "gone")


def test_a_file_read_otherwise_is_another_scene_to_the_worker(folder: Path, tmp_path: Path) -> None:
    inches, feet = ImportOptions(unit="in"), ImportOptions(unit="ft")
    catalogue = Catalogue(str(tmp_path / "outside.glb"), folder, options=inches)
    assert catalogue.served.options == catalogue.find("outside.glb").options == inches
    assert catalogue.find(None, feet).options == feet
    assert catalogue.find("a.glb").options == DEFAULT_OPTIONS
    assert catalogue.find("a.glb", feet) != catalogue.find("a.glb")


def test_the_folder_is_looked_through_again_beside_the_loop(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    catalogue = Catalogue("cornell-box", folder)
    walks: list[int] = []
    goes_on = Event()

    def slow(folder: Path) -> dict[str, str]:
        walks.append(get_ident())
        assert goes_on.wait(PATIENCE)
        return {"new.glb": str(folder / "new.glb")}

    (folder / "new.glb").write_bytes(b"")
    monkeypatch.setattr("server.scenes.catalogue.scene_files", slow)
    monkeypatch.setattr("server.scenes.catalogue.LISTED_SECONDS", 60.0)

    async def main() -> None:
        catalogue._files_until = 0.0
        looks = [asyncio.create_task(catalogue.look_up("new.glb")) for _ in range(20)]
        for _ in range(20):
            await asyncio.sleep(0)
        goes_on.set()
        await asyncio.gather(*looks)
        assert {look.result().id for look in looks} == {"new.glb"}

    asyncio.run(main())
    assert len(walks) == 1
    assert walks[0] != get_ident()


def test_thousands_of_files_are_found_by_id_without_a_walk(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    catalogue = Catalogue("cornell-box", folder)
    many = {f"{number}.glb": str(folder / "a.glb") for number in range(10_000)}
    catalogue._take(many, 0.0)
    began = time.thread_time()
    for number in range(1000):
        catalogue.find(f"{number}.glb")
    assert time.thread_time() - began < 1.0
    assert len(catalogue.names()) > 10_000
