import os
from pathlib import Path

import pytest

from server.scenes import listing
from server.scenes.listing import scene_files


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of two scenes and of what others leave there."""
    folder = tmp_path / "scenes"
    (folder / "deep").mkdir(parents=True)
    (tmp_path / "outside.glb").write_bytes(b"")
    for name in ("a.glb", "deep/b.GLTF"):
        (folder / name).write_bytes(b"")
    (folder / "inside.glb").symlink_to("deep/b.GLTF")
    (folder / "outside.glb").symlink_to(tmp_path / "outside.glb")
    (folder / "loop.glb").symlink_to("loop.glb")
    (folder / "there.glb").symlink_to("back.glb")
    (folder / "back.glb").symlink_to("there.glb")
    (folder / "dangling.glb").symlink_to("/nonexistent")
    (folder / "up").symlink_to(folder)
    (folder / "folder.glb").mkdir()
    os.mkfifo(folder / "pipe.glb")
    Path(os.fsdecode(os.fsencode(folder) + b"/\xff\xfe.glb")).write_bytes(b"")
    for name in ("\x1b[2J.glb", "line\nbreak.glb", "\u202eblg.glb"):
        (folder / name).write_bytes(b"")
    return folder


def test_each_entry_is_judged_alone(folder: Path) -> None:
    assert list(scene_files(folder)) == ["a.glb", "deep/b.GLTF", "inside.glb"]
    assert scene_files(folder)["deep/b.GLTF"] == str(folder / "deep" / "b.GLTF")


def test_what_nobody_could_ask_for_is_not_listed(folder: Path) -> None:
    long = "d" * 250
    (folder / long / long).mkdir(parents=True)
    for name in ("a" * 6, "b" * 7):
        (folder / long / long / f"{name}.glb").write_bytes(b"")
    ids = [one for one in scene_files(folder) if one.startswith("d" * 250)]
    assert [(len(one), one[-10:]) for one in ids] == [(512, "aaaaaa.glb")]


def test_a_folder_that_cannot_be_read_is_passed_over(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scan = os.scandir

    def refuse(path: str) -> object:
        if path.endswith("deep"):
            raise PermissionError(13, "Permission denied")
        return scan(path)

    monkeypatch.setattr(os, "scandir", refuse)
    assert "a.glb" in scene_files(folder)
    assert scene_files(folder / "gone") == {}


@pytest.mark.parametrize(
    ("limit", "value", "expected"),
    [("MAX_LISTED", 3, 3), ("MAX_LISTED", 2, 2), ("MAX_DEPTH", 1, 3), ("MAX_DEPTH", 0, 2), ("MAX_SECONDS", -1.0, 0)],
)
def test_the_walk_is_bounded(
    folder: Path, monkeypatch: pytest.MonkeyPatch, limit: str, value: float, expected: int
) -> None:
    monkeypatch.setattr(listing, limit, value)
    assert len(scene_files(folder)) == expected


def test_entries_that_are_no_scenes_are_bounded_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(9):
        (tmp_path / f"{number}.txt").write_bytes(b"")
    (tmp_path / "z").mkdir()
    (tmp_path / "z" / "a.glb").write_bytes(b"")
    monkeypatch.setattr(listing, "MAX_LOOKED_AT", 11)
    assert len(scene_files(tmp_path)) == 1
    monkeypatch.setattr(listing, "MAX_LOOKED_AT", 10)
    assert scene_files(tmp_path) == {}
