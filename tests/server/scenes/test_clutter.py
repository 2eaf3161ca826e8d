from pathlib import PurePosixPath

import pytest

from server.scenes.clutter import is_clutter


@pytest.mark.parametrize(
    "path",
    ["._a.glb", "house/._a.glb", "__MACOSX/a.glb", "house/__MACOSX/house/._a.glb", ".DS_Store", "a/Thumbs.db",
     "desktop.ini", "@eaDir/a.glb", "._house/a.glb"],
)  # fmt: skip
def test_what_systems_leave_is_clutter(path: str) -> None:
    assert is_clutter(PurePosixPath(path))


@pytest.mark.parametrize("path", ["a.glb", "house/a.glb", ".hidden.glb", "_a.glb", "MACOSX/a.glb", "my.DS_Store/a.glb"])
def test_what_a_person_put_there_is_none(path: str) -> None:
    assert not is_clutter(PurePosixPath(path))
