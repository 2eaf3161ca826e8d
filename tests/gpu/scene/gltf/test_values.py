from collections.abc import Callable

import pytest

from gpu.errors import SceneError
from gpu.scene.gltf.values import Value

PLACE = Value("a.gltf", "nodes[3]", {"n": 2, "half": 0.5, "list": [1, 2], "text": "a", "no": None, "huge": 2**2000})


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
        (lambda v: v.flag("n"), "must be true or false"),
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


def test_an_index_may_be_written_with_a_fraction_of_zero() -> None:
    assert Value("a.gltf", "x", 1.0).as_index(2) == 1
