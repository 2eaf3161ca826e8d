import stat
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest

from gpu.errors import SceneError
from server.scenes.archives import MAX_FILES, unpack

MEGABYTE = 2**20


def archive(folder: Path, files: Mapping[str, bytes]) -> Path:
    """A .zip with these files."""
    path = folder / "house.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as opened:
        for name, content in files.items():
            opened.writestr(name, content)
    return path


def entry(folder: Path, name: str, content: bytes = b"x", mode: int = 0, method: int = zipfile.ZIP_STORED) -> Path:
    """A .zip with a scene and one more file, called and packed as given."""
    path = folder / "house.zip"
    with zipfile.ZipFile(path, "w") as opened:
        opened.writestr("scene.glb", b"scene")
        info = zipfile.ZipInfo(name)
        info.external_attr = mode << 16
        info.compress_type = method
        opened.writestr(info, content)
    return path


@pytest.fixture
def target(tmp_path: Path) -> Path:
    folder = tmp_path / "deep" / "target"
    folder.mkdir(parents=True)
    return folder


def test_the_scene_and_its_side_files_are_unpacked(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"model/house.gltf": b"{}", "model/textures/wood.png": b"png", "readme.txt": b"hello"})
    assert unpack(packed, target, MEGABYTE) == target / "model" / "house.gltf"
    assert (target / "model" / "textures" / "wood.png").read_bytes() == b"png"


@pytest.mark.parametrize(
    "name",
    [
        "../evil",
        "/etc/evil",
        "a/../../evil",
        "..\\evil",
        "C:\\evil",
        "C:/evil",
        "new\nline",
        "x" * 256,
        "a/" * 20 + "b",
        ".",
    ],
)
def test_a_name_that_leads_elsewhere_is_refused(tmp_path: Path, target: Path, name: str) -> None:
    packed = entry(tmp_path, name)
    before = {path for path in tmp_path.rglob("*") if target not in path.parents}
    with pytest.raises(SceneError, match=r"house\.zip: .*not a plain name"):
        unpack(packed, target, MEGABYTE)
    assert {path for path in tmp_path.rglob("*") if target not in path.parents} == before
    assert list(target.iterdir()) == []


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFCHR, stat.S_IFIFO])
def test_links_and_devices_are_refused(tmp_path: Path, target: Path, kind: int) -> None:
    with pytest.raises(SceneError, match="link or a device"):
        unpack(entry(tmp_path, "link.bin", b"/etc/passwd", kind | 0o777), target, MEGABYTE)


def test_an_unusual_compression_is_refused(tmp_path: Path, target: Path) -> None:
    with pytest.raises(SceneError, match="plain deflate"):
        unpack(entry(tmp_path, "a.bin", b"x" * 1000, method=zipfile.ZIP_LZMA), target, MEGABYTE)


def test_more_bytes_than_allowed_are_refused(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"scene.glb": b"ab" * 1000, "more.bin": bytes(range(256)) * 8})
    with pytest.raises(SceneError, match="4048 bytes unpacked, more than the 4000 allowed"):
        unpack(packed, target, 4000)
    assert list(target.iterdir()) == []


def test_a_bomb_is_refused(tmp_path: Path, target: Path) -> None:
    with pytest.raises(SceneError, match="200 times its size"):
        unpack(archive(tmp_path, {"scene.glb": bytes(10 * MEGABYTE)}), target, 100 * MEGABYTE)


def test_a_lie_about_the_size_is_found(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"scene.glb": bytes(range(256)) * 40})
    content = bytearray(packed.read_bytes())
    for place in (22, content.index(b"PK\x01\x02") + 24):  # the size, in both headers
        content[place : place + 4] = (100).to_bytes(4, "little")
    packed.write_bytes(content)
    with pytest.raises(SceneError, match=r"not a \.zip file that can be unpacked"):
        unpack(packed, target, MEGABYTE)


def test_too_many_files_are_refused(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {f"file{number}": b"" for number in range(MAX_FILES + 1)})
    with pytest.raises(SceneError, match="2001 files"):
        unpack(packed, target, MEGABYTE)


@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"readme.txt": b""}, "no scene; put one of .glb"),
        ({"a.glb": b"", "b.obj": b""}, r"2 scenes \(a\.glb, b\.obj\); give one of them, with its side files"),
        ({f"{letter}.glb": b"" for letter in "abcdefghijkl"}, r"12 scenes \(a\.glb, .*, j\.glb and 2 more\)"),
        ({"house.zip": b""}, r"no scene but another archive \(house\.zip\)"),
        ({}, "no scene"),
    ],
)
def test_there_must_be_one_scene(tmp_path: Path, target: Path, files: dict[str, bytes], says: str) -> None:
    with pytest.raises(SceneError, match=says):
        unpack(archive(tmp_path, files), target, MEGABYTE)


def test_scenes_in_folders_belong_to_the_one_above(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"parts/a.usdc": b"1", "house.usda": b"2", "parts/b.usdc": b"3"})
    assert unpack(packed, target, MEGABYTE) == target / "house.usda"


def test_what_a_mac_adds_is_left_out(tmp_path: Path, target: Path) -> None:
    clutter = ["__MACOSX/a.glb", "._a.glb", ".DS_Store", "Thumbs.db", "desktop.ini", "__MACOSX\\._b.glb"]
    unpack(archive(tmp_path, {"a.glb": b"1", **dict.fromkeys(clutter, b"2")}), target, MEGABYTE)
    assert [path.name for path in target.rglob("*")] == ["a.glb"]


def test_names_with_backslashes_are_paths_and_may_be_folders(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"model\\": b"", "model\\house.gltf": b"{}", "model\\maps\\wood.png": b"png"})
    assert unpack(packed, target, MEGABYTE) == target / "model" / "house.gltf"
    assert (target / "model" / "maps" / "wood.png").read_bytes() == b"png"


@pytest.mark.parametrize("encoding", ["utf-8", "cp437"])
def test_names_that_are_not_marked_as_utf_8_are_read(tmp_path: Path, target: Path, encoding: str) -> None:
    letter = "\N{LATIN SMALL LETTER U WITH DIAERESIS}".encode(encoding)
    packed = archive(tmp_path, {f"K{'x' * len(letter)}che.glb": b"1"})
    packed.write_bytes(packed.read_bytes().replace(b"x" * len(letter), letter))
    assert unpack(packed, target, MEGABYTE).name == "K\N{LATIN SMALL LETTER U WITH DIAERESIS}che.glb"


def test_names_that_are_marked_as_utf_8_are_read(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"K\N{LATIN SMALL LETTER U WITH DIAERESIS}che.glb": b"1"})
    assert unpack(packed, target, MEGABYTE).name == "K\N{LATIN SMALL LETTER U WITH DIAERESIS}che.glb"


@pytest.mark.parametrize("damage", [b"", b"no archive", None])
def test_what_is_no_archive_is_refused(tmp_path: Path, target: Path, damage: bytes | None) -> None:
    packed = archive(tmp_path, {"scene.glb": bytes(range(256)) * 40})
    packed.write_bytes(packed.read_bytes()[:-10] if damage is None else damage)
    with pytest.raises(SceneError, match=r"house\.zip: not a \.zip"):
        unpack(packed, target, MEGABYTE)


def test_broken_data_is_refused(tmp_path: Path, target: Path) -> None:
    packed = archive(tmp_path, {"scene.glb": bytes(range(256)) * 40})
    content = bytearray(packed.read_bytes())
    content[60:90] = bytes(30)
    packed.write_bytes(content)
    with pytest.raises(SceneError, match=r"house\.zip"):
        unpack(packed, target, MEGABYTE)


def test_a_file_that_is_a_folder_too_is_refused_without_our_paths(tmp_path: Path, target: Path) -> None:
    with pytest.raises(SceneError, match="cannot be unpacked") as caught:
        unpack(archive(tmp_path, {"a": b"x", "a/scene.glb": b"x"}), target, MEGABYTE)
    assert str(tmp_path) not in str(caught.value)
