import asyncio
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from glb_file import TRIANGLE_GLB

from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from server.scenes.checker import Checker
from server.scenes.kept_scenes import KeptScene, KeptScenes
from server.scenes.packed_scene import read_scene
from server.settings import ServerSettings


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, int], KeptScene]:
    """Makes a scene of a file of that name, in which a reader has left so many bytes."""

    def made(name: str, count: int) -> KeptScene:
        (tmp_path / name).write_bytes(b"file")
        scene = KeptScene(str(tmp_path / name), DEFAULT_OPTIONS)
        os.write(scene.memory, bytes(count))
        return scene

    return made


def test_what_was_checked_is_kept_until_it_is_taken(tmp_path: Path) -> None:
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB)
    checker = Checker(ServerSettings())
    asyncio.run(checker.check(str(tmp_path / "hall.glb"), "hall"))
    (tmp_path / "hall.glb").rename(tmp_path / "moved.glb")  # as uploads are
    moved = str(tmp_path / "moved.glb")
    assert checker.kept.take(moved, ImportOptions(up="z")) is None
    kept = checker.kept.take(moved, DEFAULT_OPTIONS)
    assert kept is not None
    with pytest.raises(PermissionError):
        os.write(kept.memory, b"x")
    with Path(kept.path).open("rb") as file:
        assert len(read_scene(file, "hall", SceneLimits()).triangles) == 1
    assert checker.kept.take(moved, DEFAULT_OPTIONS) is None


def test_what_nobody_wants_is_kept_for_a_while(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.scenes.checker.KEPT_SECONDS", 0.05)
    (tmp_path / "hall.glb").write_bytes(TRIANGLE_GLB)

    async def check_and_wait() -> bool:
        checker = Checker(ServerSettings())
        await checker.check(str(tmp_path / "hall.glb"), "hall")
        await asyncio.sleep(0.2)
        return checker.kept.take(str(tmp_path / "hall.glb"), DEFAULT_OPTIONS) is None

    assert asyncio.run(check_and_wait())


def test_a_file_that_has_changed_is_read_again(tmp_path: Path, write: Callable[[str, int], KeptScene]) -> None:
    kept = KeptScenes()
    kept.keep(write("hall.glb", 8))
    (tmp_path / "hall.glb").write_bytes(b"another")
    assert kept.take(str(tmp_path / "hall.glb"), DEFAULT_OPTIONS) is None
    assert kept.take(str(tmp_path / "gone.glb"), DEFAULT_OPTIONS) is None


def test_the_oldest_makes_room_and_what_is_too_large_or_nothing_is_not_kept(
    tmp_path: Path, write: Callable[[str, int], KeptScene]
) -> None:
    kept = KeptScenes(most_bytes=100)
    for name, count in (("a", 60), ("b", 40), ("c", 101), ("d", 0), ("e", 50)):
        kept.keep(write(name, count))
    taken = {name: kept.take(str(tmp_path / name), DEFAULT_OPTIONS) for name in "abcde"}
    assert [name for name, scene in taken.items() if scene is not None] == ["b", "e"]
    descriptor = taken.pop("b")
    assert descriptor is not None
    path = Path(descriptor.path)
    del descriptor
    assert not path.exists()  # its memory is free again
