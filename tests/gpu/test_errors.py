from gpu.errors import DeviceError, ImageError, OutOfMemoryError, SceneError, UserError


def test_a_scenes_error_names_the_file_the_place_and_what_to_do() -> None:
    error = SceneError("house.glb", "meshes[2]", "has no positions; export it anew")
    assert str(error) == "house.glb: meshes[2]: has no positions; export it anew"
    assert (error.source, error.field, error.problem) == ("house.glb", "meshes[2]", "has no positions; export it anew")
    assert str(SceneError("house.glb", "", "is empty")) == "house.glb: is empty"


def test_all_that_a_user_can_mend_is_caught_as_one() -> None:
    assert all(issubclass(kind, UserError) for kind in (SceneError, DeviceError, OutOfMemoryError, ImageError))
