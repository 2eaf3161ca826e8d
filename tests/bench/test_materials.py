from pathlib import Path

import pytest

from gpu.errors import UserError
from tests.bench.materials import run
from tests.bench.suite import Suite


def test_without_references_it_says_what_it_needs(tmp_path: Path, cpu: str) -> None:
    with pytest.raises(UserError, match="materials: needs --scenes"):
        run(Suite(out=tmp_path, cache=tmp_path, device=cpu))
