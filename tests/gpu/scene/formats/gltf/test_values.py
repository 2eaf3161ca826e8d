from collections.abc import Callable
from math import nan, pi

import pytest

from gpu.errors import SceneError
from gpu.scene.formats.gltf.values import Value, kind_of

PLACE = Value(
    "a.gltf", "nodes[3]", {"n": 2, "half": 0.5, "list": [1, 2], "text": "a", "no": None, "huge": 2**2000, "nan": nan}
)


@pytest.mark.parametrize(
    ("read", "says"),
    [
        (lambda v: v.get("missing"), "nodes[3]: 'missing' is missing"),
        (lambda v: v.number("text"), "nodes[3].text: must be a number"),
        (lambda v: v.number("no"), "nodes[3].no: must be a number"),
        (lambda v: v.number("huge"), "nodes[3].huge: must be a number"),
        (lambda v: v.number("n", low=3.0), "nodes[3].n: must be between 3"),
        (lambda v: v.integer("half"), "must be an integer"),
        (lambda v: v.get("n").as_index(2), "2 does not exist, there are 2"),
        (lambda v: v.get("half").as_index(2), "must be an index"),
        (lambda v: v.numbers("list", (0.0, 0.0, 0.0)), "must have 3 numbers, not 2"),
        (lambda v: v.objects("list"), "nodes[3].list[0]: must be an object"),
        (lambda v: v.items("n"), "must be an array"),
        (lambda v: v.object("n"), "must be an object"),
        (lambda v: v.text("n"), "must be a string"),
        (lambda v: v.number("nan"), "nodes[3].nan: must be a finite number"),
    ],
)
def test_a_wrong_value_is_an_error_with_its_path(read: Callable[[Value], object], says: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(PLACE)
    assert says in str(caught.value)
    assert str(caught.value).startswith("a.gltf: nodes[3]")


def test_missing_values_have_defaults() -> None:
    assert PLACE.number("missing", 7.0) == 7.0
    assert PLACE.numbers("missing", (1.0, 2.0)) == (1.0, 2.0)
    assert PLACE.items("missing") == []
    assert PLACE.object("missing").raw == {}
    assert PLACE.extension("KHR_x") is None
    assert PLACE.flag("missing") is False


@pytest.mark.parametrize(
    ("read", "value", "says"),
    [
        (lambda v: v.factor("n", 1.0, 0.0, 1.0), 1.0, "nodes[3].n: must be between 0 and 1, not 2; 1 was used"),
        (lambda v: v.factor("text", 0.5), 0.5, "nodes[3].text: must be a number, not 'a'; 0.5 was used"),
        (lambda v: v.factor("nan", 0.5), 0.5, "nodes[3].nan: must be a finite number, not nan; 0.5 was used"),
        (lambda v: v.factors("list", (7.0, 8.0, 9.0)), (1.0, 2.0, 9.0), "nodes[3].list: must have 3 numbers, not 2"),
        (lambda v: v.factors("list", (7.0,)), (1.0,), "nodes[3].list: must have 1 numbers, not 2"),
        (lambda v: v.factors("n", (7.0,)), (7.0,), "nodes[3].n: must be an array; it was left out"),
        (lambda v: v.part("n").raw, {}, "nodes[3].n: must be an object; it was left out"),
        (lambda v: v.choice("n", {1: "one"}, "none"), "none", "nodes[3].n: must be one of 1, not 2"),
        (lambda v: v.choice("list", {1: "one"}, "none"), "none", "nodes[3].list: must be one of 1, not [1, 2]"),
        (lambda v: v.flag("text"), False, "nodes[3].text: must be one of True, False, not 'a'"),
    ],
)
def test_a_wrong_part_or_factor_is_mended(read: Callable[[Value], object], value: object, says: str) -> None:
    place = Value(PLACE.source, PLACE.path, PLACE.raw)
    assert read(place) == value
    (note,) = place.notes.sentences()
    assert note.startswith(says)


def test_rounding_to_float32_is_within_limits() -> None:
    place = Value("a.gltf", "", {"angle": 1.5707963705062866, "more": 1.5708})
    assert place.number("angle", high=pi / 2) == place.factor("angle", 0.0, high=pi / 2) == pi / 2
    assert place.notes.sentences() == ()
    assert place.factor("more", 0.0, high=pi / 2) == pi / 2
    assert len(place.notes.sentences()) == 1


def test_half_a_surrogate_pair_becomes_a_question_mark() -> None:
    assert Value("a.gltf", "", {"name": "a\ud800"}).name() == "a?"


def test_the_kind_of_a_path_has_no_numbers() -> None:
    assert kind_of("meshes[12].primitives[0]") == "meshes[].primitives[]"


def test_an_index_may_be_written_with_a_fraction_of_zero() -> None:
    assert Value("a.gltf", "x", 1.0).as_index(2) == 1
