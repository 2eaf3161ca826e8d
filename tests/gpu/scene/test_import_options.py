import pytest
from pydantic import ValidationError

from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions


def test_what_is_not_said_is_as_the_file_says() -> None:
    assert ImportOptions() == DEFAULT_OPTIONS
    assert (DEFAULT_OPTIONS.up, DEFAULT_OPTIONS.unit, DEFAULT_OPTIONS.origin) == (None, None, None)


@pytest.mark.parametrize(
    "wrong",
    [{"up": "x"}, {"unit": "km"}, {"origin": (0.0, 0.0)}, {"origin": (0.0, 0.0, float("nan"))}, {"storeys": [""]}],
    ids=str,
)
def test_what_no_file_can_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        ImportOptions.model_validate(wrong)
