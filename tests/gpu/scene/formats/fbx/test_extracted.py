import sys
from pathlib import Path

import numpy as np
import pytest
from fbx_file import FbxFile

from gpu.errors import SceneError
from gpu.scene.formats.fbx import load_fbx
from gpu.scene.formats.fbx.extracted import matrix_of
from gpu.scene.limits import SceneLimits

ufbx = pytest.importorskip("ufbx")


@pytest.mark.parametrize("content", [b"", b"no FBX file", b"Kaydara FBX Binary  \0\x1a\0" + bytes(40), b"v 0 0 0\n"])
def test_broken_files(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.fbx").write_bytes(content)
    with pytest.raises(SceneError, match=r"a\.fbx: (not an FBX file that can be read: \w|no triangles)"):
        load_fbx(tmp_path / "a.fbx")


def test_limits(tmp_path: Path) -> None:
    fbx = FbxFile(tmp_path)
    fbx.mesh(fbx.node("Floor", "Mesh"))
    for limits in (SceneLimits(max_file_bytes=20), SceneLimits(max_triangles=1)):
        with pytest.raises(SceneError, match="more than"):
            load_fbx(fbx.write(), limits)


def test_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ufbx", None)
    with pytest.raises(SceneError, match=r"needs the extra fbx: pip install lumenwalk\[fbx\]"):
        load_fbx(tmp_path / "a.fbx")


def test_a_matrix_has_its_columns() -> None:
    matrix = matrix_of([[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]])
    assert np.array_equal(matrix @ (0, 0, 0, 1), (10, 11, 12, 1))
    assert np.array_equal(matrix[:3, 0], (1, 2, 3))
