import io
import zipfile
from pathlib import Path

import pytest

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.formats.package import Package
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits

PATH = Path("scene.zae")


def zipped(**files: bytes) -> bytes:
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.mkdir("folder")
        for name, content in files.items():
            archive.writestr(f"folder/{name}.txt", content)
    return written.getvalue()


def test_files_are_found_in_any_case() -> None:
    package = Package(PATH, zipped(A=b"1", b=b"2"), DEFAULT_LIMITS)
    assert package.names == ["folder/A.txt", "folder/b.txt"]
    assert [package.find(name) for name in ("/Folder/a.TXT", "folder\\b.txt", "c.txt")] == [*package.names, None]
    assert package.read("folder/b.txt") == b"2"


@pytest.mark.parametrize("encoding", ["utf-8", "cp437"])
def test_names_that_are_not_marked_as_utf_8_are_read(encoding: str) -> None:
    letter = "\N{LATIN SMALL LETTER U WITH DIAERESIS}"
    written = letter.encode(encoding)
    content = zipped(**{"x" * len(written): b"1"}).replace(b"/" + b"x" * len(written), b"/" + written)
    package = Package(PATH, content, DEFAULT_LIMITS)
    assert package.names == [f"folder/{letter}.txt"]
    assert package.read(package.names[0]) == b"1"


def test_no_more_is_unpacked_than_a_file_may_have() -> None:
    package = Package(PATH, zipped(a=bytes(600), b=bytes(600)), SceneLimits(max_file_bytes=1000))
    package.read("folder/a.txt")
    with pytest.raises(ForbiddenError, match="1,200 bytes unpacked, more than the 1,000 allowed"):
        package.read("folder/b.txt")


def test_no_more_is_unpacked_than_scenes_are_packed() -> None:
    package = Package(PATH, zipped(a=b"a", b=bytes(1_000_000)), DEFAULT_LIMITS)
    package.read("folder/a.txt")
    with pytest.raises(ForbiddenError, match="more than 200 times its size"):
        package.read("folder/b.txt")


@pytest.mark.parametrize("content", [b"", b"<a/>", zipped(a=b"1" * 999)[:-30]])
def test_what_is_no_zip_file_is_refused(content: bytes) -> None:
    with pytest.raises(SceneError, match=r"not a \.zae file that can be unpacked"):
        Package(PATH, content, DEFAULT_LIMITS)


def test_a_broken_file_in_it_is_refused() -> None:
    content = bytearray(zipped(a=bytes(range(256))))
    start = content.index(b"a.txt") + 20
    content[start : start + 20] = bytes(20)
    with pytest.raises(SceneError, match="can be unpacked"):
        Package(PATH, bytes(content), DEFAULT_LIMITS).read("folder/a.txt")
