from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from usd_file import UsdFile


@pytest.fixture
def usd(tmp_path: Path) -> "UsdFile":
    """An empty USD file in a folder of its own."""
    from usd_file import UsdFile

    folder = tmp_path / "scene"
    folder.mkdir()
    return UsdFile(folder)
