import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.import_options import ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.scene_parts import MeshPart, SceneParts, check_choices, check_parts
from gpu.scene.types import Material

PART = MeshPart(np.eye(3), np.array([[0, 1, 2]], np.int32), name="wall")


def test_a_part_is_one_object_unless_it_says_which_several() -> None:
    names, owners = PART.owners
    assert names == ("wall",)
    assert owners.tolist() == [0, 0, 0]
    both = MeshPart(PART.positions, PART.triangles, objects=("a", "b"), vertex_object=np.array([0, 1, 1], np.int32))
    assert both.owners[0] == ("a", "b")
    assert both.owners[1].tolist() == [0, 1, 1]


def test_a_material_that_is_not_there_is_named() -> None:
    check_parts("room", SceneParts([PART], [Material()]), DEFAULT_LIMITS)
    with pytest.raises(SceneError, match=r"wall\.material"):
        check_parts("room", SceneParts([PART], []), DEFAULT_LIMITS)


def test_a_variant_that_is_not_there_is_refused_with_those_that_are() -> None:
    choices = {"variant": ["red", "blue"]}
    check_choices("room", choices, ImportOptions(variant="red"))
    with pytest.raises(SceneError, match=r"no variant 'green' in it; it has red, blue"):
        check_choices("room", choices, ImportOptions(variant="green"))
    with pytest.raises(SceneError, match="it has none"):
        check_choices("room", {}, ImportOptions(storeys=("1",)))
