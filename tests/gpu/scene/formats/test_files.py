import os
from pathlib import Path

import pytest

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.formats.files import confined_file, noting_files, read_bytes, read_uri
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.remarks import Remarks


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "outside.bin").write_bytes(b"no")
    (tmp_path / "scene" / "sub").mkdir(parents=True)
    (tmp_path / "scene" / "sub" / "a.bin").write_bytes(b"yes")
    (tmp_path / "scene" / "inner").symlink_to("sub")
    (tmp_path / "scene" / "outer").symlink_to(tmp_path)
    return tmp_path / "scene" / "scene.gltf"


@pytest.mark.parametrize(
    "name", ["sub/a.bin", "./sub/a.bin", "sub\\a.bin", "inner/a.bin", "sub/../sub/a.bin", "../scene/sub/a.bin"]
)
def test_files_in_the_folder_are_found(scene: Path, name: str) -> None:
    path = confined_file(scene, name, "here")
    assert path is not None
    assert path.read_bytes() == b"yes"


def test_what_is_looked_for_beside_a_scene_is_noted(scene: Path) -> None:
    with noting_files() as files:
        confined_file(scene, "SUB/A.bin", "here")
        confined_file(scene, "away.bin", "here")
        with pytest.raises(ForbiddenError):
            confined_file(scene, "../outside.bin", "here")
    confined_file(scene, "later.bin", "here")
    folder = scene.parent.resolve()
    assert files == {folder / "sub" / "a.bin": (folder / "sub" / "a.bin").stat().st_mtime_ns, folder / "away.bin": 0}


@pytest.mark.parametrize("name", ["nothing.bin", "sub", "a\0", "x" * 9999, "."])
def test_what_is_no_file_is_none(scene: Path, name: str) -> None:
    assert confined_file(scene, name, "here") is None


@pytest.mark.parametrize("name", ["../outside.bin", "sub/../../outside.bin", "../scenes/sub/a.bin", "/etc/passwd",
                                  "outer/outside.bin", "..\\outside.bin"])  # fmt: skip
def test_what_is_outside_is_refused(scene: Path, name: str) -> None:
    with pytest.raises(SceneError, match=r"here: .* outside the scene's folder"):
        confined_file(scene, name, "here")


@pytest.mark.parametrize(
    "name", ["Sub/A.bin", "SUB\\a.BIN", "a\N{COMBINING DIAERESIS}.bin", "\N{LATIN SMALL LETTER A WITH DIAERESIS}.bin"]
)
def test_case_and_composition_of_letters_do_not_matter(scene: Path, name: str) -> None:
    (scene.parent / "A\N{COMBINING DIAERESIS}.bin").write_bytes(b"yes")
    path = confined_file(scene, name, "here")
    assert path is not None
    assert path.read_bytes() == b"yes"


@pytest.mark.parametrize(
    ("uri", "notes"),
    [
        ("sub/%61.bin", 0),
        ("sub/a.bin?v=2", 0),
        ("sub/a.bin#top", 0),
        ("100%25.bin", 0),
        ("100%.bin", 0),
        ("b%20c.bin", 0),
        (".\\100%25.bin", 0),
        ("SUB/a.bin", 1),
        ("/home/someone/100%.bin", 1),
        ("C:\\maps\\100%.bin", 1),
        ("c:/maps/100%25.bin", 1),
        ("\\\\server\\maps\\100%.bin", 1),
        ("file:///home/someone/100%25.bin", 1),
        ("FILE://C:/100%25.bin", 1),
        ("file:///C:/Users/me/scene/sub/a.bin", 1),
        ("D:\\job\\Sub\\A.bin", 1),
        ("D:\\job\\sub\\..\\sub\\a.bin", 1),
        ("D:\\sub\\100%.bin", 1),
        ("data:text/plain;base64,eWVz", 0),
        ("data:;base64,eW\nVz", 0),
        ("data:application/octet-stream;base64,eWVz Cg", 0),
        ("data:,y%65s", 0),
    ],
)
def test_uris(scene: Path, uri: str, notes: int) -> None:
    for name in ("100%.bin", "b%20c.bin"):
        (scene.parent / name).write_bytes(b"yes")
    remarks = Remarks()
    assert read_uri(scene, uri, "here", DEFAULT_LIMITS, remarks).startswith(b"yes")
    assert len(remarks.sentences()) == notes


@pytest.mark.parametrize(
    ("uri", "says"),
    [
        ("http://example.org/a.bin", "not fetched from the network"),
        ("s3://bucket/a.bin", "not fetched from the network"),
        ("/home/someone/none.bin", "does not exist beside the scene"),
        ("C:\\", "does not exist beside the scene"),
        ("", "does not exist beside the scene"),
        ("data:base64", "a data URI without a comma"),
        ("data:;base64,a", "broken base64"),
    ],
)
def test_a_uri_of_nothing_is_an_error(scene: Path, uri: str, says: str) -> None:
    with pytest.raises(SceneError, match=says) as caught:
        read_uri(scene, uri, "here", DEFAULT_LIMITS, Remarks())
    assert not isinstance(caught.value, ForbiddenError)


@pytest.mark.parametrize("uri", ["../outside.bin", "%2e%2e/outside.bin", "outer/outside.bin", "/..", "file:///a/.."])
def test_a_uri_outside_is_forbidden(scene: Path, uri: str) -> None:
    with pytest.raises(ForbiddenError):
        read_uri(scene, uri, "here", DEFAULT_LIMITS, Remarks())


def test_a_file_over_the_limit_is_not_read(scene: Path) -> None:
    with pytest.raises(SceneError, match=r"3 bytes, more than the 2 allowed; .*max_file_bytes"):
        read_bytes(scene.parent / "sub" / "a.bin", SceneLimits(max_file_bytes=2))


def test_a_pipe_is_not_waited_for(scene: Path) -> None:
    os.mkfifo(scene.parent / "pipe.bin")
    for name in ("pipe.bin", "sub"):
        with pytest.raises(SceneError, match=r"cannot be read: (it is no plain file|Is a directory)"):
            read_bytes(scene.parent / name, DEFAULT_LIMITS)


def test_a_pointer_of_git_lfs_is_no_scene(tmp_path: Path) -> None:
    (tmp_path / "a.glb").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 5\n")
    with pytest.raises(SceneError, match="Git LFS, not the file itself; fetch that"):
        read_bytes(tmp_path / "a.glb", DEFAULT_LIMITS)
