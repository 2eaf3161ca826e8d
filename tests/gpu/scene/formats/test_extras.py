import json

import pytest

from gpu.errors import SceneError
from gpu.scene.formats.extras import library


def test_a_library_that_is_there() -> None:
    assert library("a.usda", "json", "usd") is json


def test_a_library_that_is_not_there_is_named_by_its_extra() -> None:
    with pytest.raises(SceneError, match=r"a\.usda: needs the extra usd: pip install lumenwalk\[usd\]"):
        library("a.usda", "no_such_module", "usd")
