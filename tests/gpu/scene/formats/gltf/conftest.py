from pathlib import Path

import pytest
from gltf_file import GltfFile


@pytest.fixture
def gltf(tmp_path: Path) -> GltfFile:
    """An empty glTF file in a folder of its own."""
    folder = tmp_path / "scene"
    folder.mkdir()
    return GltfFile(folder)
