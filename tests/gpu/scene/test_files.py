from pathlib import Path

import pytest

from gpu.errors import SceneError
from gpu.scene.files import confined_file, read_bytes, read_uri
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "outside.bin").write_bytes(b"no")
    (tmp_path / "scene" / "sub").mkdir(parents=True)
    (tmp_path / "scene" / "sub" / "a.bin").write_bytes(b"yes")
    (tmp_path / "scene" / "inner").symlink_to("sub")
    (tmp_path / "scene" / "outer").symlink_to(tmp_path)
    return tmp_path / "scene" / "scene.gltf"


@pytest.mark.parametrize("name", ["sub/a.bin", "./sub/a.bin", "sub\\a.bin", "inner/a.bin"])
def test_files_in_the_folder_are_found(scene: Path, name: str) -> None:
    path = confined_file(scene, name, "here")
    assert path is not None
    assert path.read_bytes() == b"yes"


@pytest.mark.parametrize("name", ["nothing.bin", "sub", "a\0", "x" * 9999, "."])
def test_what_is_no_file_is_none(scene: Path, name: str) -> None:
    assert confined_file(scene, name, "here") is None


@pytest.mark.parametrize("name", ["../outside.bin", "sub/../../outside.bin", "sub/../sub/a.bin", "/etc/passwd",
                                  "outer/outside.bin", "..\\outside.bin"])  # fmt: skip
def test_what_is_outside_is_refused(scene: Path, name: str) -> None:
    with pytest.raises(SceneError, match=r"here: .* outside the scene's folder"):
        confined_file(scene, name, "here")


def test_uris(scene: Path) -> None:
    assert read_uri(scene, "sub/%61.bin", "here", DEFAULT_LIMITS) == b"yes"
    assert read_uri(scene, "data:text/plain;base64,eWVz", "here", DEFAULT_LIMITS) == b"yes"
    assert read_uri(scene, "data:,y%65s", "here", DEFAULT_LIMITS) == b"yes"


def test_a_file_over_the_limit_is_not_read(scene: Path) -> None:
    with pytest.raises(SceneError, match=r"3 bytes, more than the 2 allowed; .*max_file_bytes"):
        read_bytes(scene.parent / "sub" / "a.bin", SceneLimits(max_file_bytes=2))
