from dataclasses import replace

import numpy as np
import pytest

from gpu.scene.load import load_scene
from tests.bench.gate import ADVICE, SCENES, check_scene, complaints, same, signature

STORED = {"room": {"indirect": {"mse": 0.01, "nonfinite": 0}}}


@pytest.mark.parametrize("name", SCENES)
def test_no_error_rose(name: str) -> None:
    lines = check_scene(name)
    assert not lines, "\n".join([*lines, ADVICE])


@pytest.mark.parametrize("mse", [0.005, 0.01, 0.0105])
def test_less_error_and_a_little_more_pass(mse: float) -> None:
    assert not complaints({"room": {"indirect": {"mse": mse, "nonfinite": 0}}}, STORED)


@pytest.mark.parametrize(
    ("now", "message"),
    [
        ({"mse": 0.012}, "mse is 0.012, was 0.01"),
        ({"mse": float("nan")}, "mse is nan"),
        ({"nonfinite": 1}, "nonfinite is 1, was 0"),
        ({"rel_mse": 0.0}, "not stored"),
    ],
)
def test_more_error_and_what_is_no_number_and_what_is_not_stored_fail(now: dict[str, float], message: str) -> None:
    lines = complaints({"room": {"indirect": now}}, STORED)
    assert len(lines) == 1
    assert message in lines[0]


def test_a_scene_is_known_again_and_another_is_not() -> None:
    scene = load_scene("cornell-box")
    numbers = signature(scene)
    moved = replace(scene, vertices=(scene.vertices * 1.01).astype(np.float32))
    rounded = replace(scene, vertices=(scene.vertices * (1.0 + 1e-7)).astype(np.float32))
    assert same(numbers, signature(rounded))
    assert not same(numbers, signature(moved))
    assert not same(None, numbers)
