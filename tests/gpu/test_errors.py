import pytest

from gpu.errors import (
    MOST_PLACE,
    MOST_PROBLEM,
    DeviceError,
    ImageError,
    OutOfMemoryError,
    SceneError,
    UserError,
    brief,
)


def test_a_scenes_error_names_the_file_the_place_and_what_to_do() -> None:
    error = SceneError("house.glb", "meshes[2]", "has no positions; export it anew")
    assert str(error) == "house.glb: meshes[2]: has no positions; export it anew"
    assert (error.source, error.field, error.problem) == ("house.glb", "meshes[2]", "has no positions; export it anew")
    assert str(SceneError("house.glb", "", "is empty")) == "house.glb: is empty"


def test_all_that_a_user_can_mend_is_caught_as_one() -> None:
    assert all(issubclass(kind, UserError) for kind in (SceneError, DeviceError, OutOfMemoryError, ImageError))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hall", "hall"),
        ("1234567890", "1234567890"),
        ("12345678901", "123456789…"),
        (10**7 * "n", "nnnnnnnnn…"),
        ("a\nb\r\tc", "a b  c"),
        ("\ud800\x00\x1b[2m", "���[2m"),
        ("\u202etxt", "�txt"),
        ("Büro 𝟙", "Büro 𝟙"),
    ],
)
def test_a_quoted_text_is_one_short_line(text: str, said: str) -> None:
    assert brief(text, 10) == said


def test_what_a_file_brings_into_an_error_is_cut() -> None:
    error = SceneError("house.glb", 10**7 * "f", 10**7 * "p")
    assert len(str(error)) == len("house.glb: : ") + MOST_PLACE + MOST_PROBLEM
