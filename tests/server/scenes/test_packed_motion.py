import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gltf_motion import moving
from pydantic import ValidationError

from gpu.scene.animation.motion import Motion
from gpu.scene.types import Scene
from server.scenes.packed_motion import PackedMotion, pack_motion, unpack_motion

Words = dict[str, Any]
Arrays = list[np.ndarray]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """One with all that can move."""
    return moving(tmp_path_factory.mktemp("scene")).load()


def packed(motion: Motion | None) -> tuple[Words, Arrays]:
    """What moves, in JSON's types, and its arrays in the order in which they are met."""
    arrays: Arrays = []

    def number_of(array: np.ndarray) -> int:
        arrays.append(array)
        return len(arrays) - 1

    assert motion is not None
    return json.loads(json.dumps(pack_motion(motion, number_of))), arrays


def test_what_moves_comes_back_as_it_was(scene: Scene) -> None:
    words, arrays = packed(scene.motion)
    again, others = packed(unpack_motion(PackedMotion.model_validate(words), arrays))
    assert again == words
    assert all(one is other for one, other in zip(arrays, others, strict=True))


def body_with(name: str) -> Callable[[Words], Words]:
    """The first body that has a skin or targets."""
    return lambda words: next(body for body in words["bodies"] if body[name])


def put(words: Words, arrays: Arrays, name: str, change: Callable[[np.ndarray], Any]) -> None:
    """Has a changed copy of an array in its place."""
    arrays.append(np.asarray(change(arrays[words[name]].copy())))
    words[name] = len(arrays) - 1


def minus_one(array: np.ndarray) -> np.ndarray:
    array.reshape(-1)[0] = -1
    return array


@pytest.mark.parametrize(
    ("place", "name", "change", "said"),
    [
        (lambda words: words, "parents", lambda a: a + np.int32(99), "nodes do not come after"),
        (lambda words: words, "local", lambda a: a[1:], "shape"),
        (lambda words: words, "rest", lambda a: a * np.nan, "is not finite"),
        (lambda words: words["animations"][0]["channels"][0], "times", lambda a: a[::-1].copy(), "keys that go back"),
        (lambda words: words["animations"][0]["channels"][0], "values", lambda a: a[:, :, :2], "shape"),
        (body_with("normals"), "normals", lambda a: a.astype(np.float32), "<f4 of shape"),
        (body_with("triangles"), "triangles", minus_one, "refers to what is not there"),
        (body_with("vertices"), "vertices", lambda a: a + np.int32(9), "refers to what is not there"),
        (body_with("skin"), "joints", lambda a: a + np.int32(9), "refers to what is not there"),
        (body_with("skin"), "shares", lambda a: a[:, :1], "shape"),
        (lambda words: body_with("skin")(words)["skin"], "joints", minus_one, "refers to what is not there"),
        (lambda words: body_with("targets")(words)["targets"][0], "positions", lambda a: a[:1], "shape"),
    ],
)
def test_arrays_that_are_not_sound_are_refused(
    place: Callable[[Words], Words], name: str, change: Callable[[np.ndarray], Any], said: str, scene: Scene
) -> None:
    words, arrays = packed(scene.motion)
    put(place(words), arrays, name, change)
    with pytest.raises(ValueError, match=said):
        unpack_motion(PackedMotion.model_validate(words), arrays)


@pytest.mark.parametrize(
    "change",
    [
        lambda words: words.update(lights=[99]),
        lambda words: words.update(animations=[]),
        lambda words: words.update(parents=-1),
        lambda words: words.update(parents=999),
        lambda words: words["bodies"][0].update(node=99),
        lambda words: words["animations"][0].update(seconds=float("inf")),
        lambda words: words["animations"][0]["channels"][0].update(part=99),
        lambda words: words["animations"][0]["channels"][0].update(interpolation="CUBICSPLINE"),
    ],
)
def test_words_that_are_not_sound_are_refused(change: Callable[[Words], None], scene: Scene) -> None:
    words, arrays = packed(scene.motion)
    change(words)
    with pytest.raises((ValueError, ValidationError, IndexError)):
        unpack_motion(PackedMotion.model_validate(words), arrays)
