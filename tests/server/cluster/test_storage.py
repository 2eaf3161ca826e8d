from pathlib import Path

import pytest

pytest.importorskip("fsspec")

import fsspec

from gpu.errors import UserError
from server.cluster.storage import PART, Mirror

STORE = "memory://bucket/scenes"


def put(name: str, content: bytes) -> None:
    fsspec.filesystem("memory").pipe(f"/bucket/scenes/{name}", content)


def here(folder: Path) -> dict[str, bytes]:
    return {str(it.relative_to(folder)): it.read_bytes() for it in folder.rglob("*") if it.is_file()}


def test_a_folder_follows_a_store(tmp_path: Path) -> None:
    put("hall.glb", b"hall")
    put("rooms/attic.gltf", b"attic")
    mirror = Mirror(STORE, tmp_path)
    mirror.update()
    assert here(tmp_path) == {"hall.glb": b"hall", "rooms/attic.gltf": b"attic"}
    kept = (tmp_path / "hall.glb").stat().st_ino
    put("rooms/attic.gltf", b"another attic")
    mirror.update()
    assert here(tmp_path)["rooms/attic.gltf"] == b"another attic"
    assert (tmp_path / "hall.glb").stat().st_ino == kept  # what has not changed is not fetched again
    fsspec.filesystem("memory").rm("/bucket/scenes/hall.glb")
    mirror.update()
    assert here(tmp_path) == {"rooms/attic.gltf": b"another attic"}


@pytest.mark.parametrize("kind", [OSError, RuntimeError])  # some stores have errors of their own
def test_a_file_that_cannot_be_fetched_leaves_the_older_one(
    kind: type[Exception], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    put("cellar.glb", b"old")
    mirror = Mirror(STORE, tmp_path)
    mirror.update()
    put("cellar.glb", b"newer")
    with monkeypatch.context() as broken:

        def fail(source: str, target: str) -> None:
            Path(target).write_bytes(b"ne")
            raise kind("the line is cut")

        broken.setattr(mirror._store, "get_file", fail)
        mirror.update()
    assert (tmp_path / "cellar.glb").read_bytes() == b"old"
    assert "the line is cut" in caplog.text
    mirror.update()
    assert (tmp_path / "cellar.glb").read_bytes() == b"newer"
    assert not (tmp_path / f"cellar.glb{PART}").exists()


def test_no_file_leads_out_of_the_folder(tmp_path: Path) -> None:
    mirror = Mirror(STORE, tmp_path)
    assert mirror._name(f"{mirror._root}/../x.glb") is None
    assert mirror._name(mirror._root) is None


def test_a_store_that_nothing_speaks_to_is_said() -> None:
    with pytest.raises(UserError, match="storage: nosuch://"):
        Mirror("nosuch://bucket", Path())
