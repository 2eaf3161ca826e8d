import pytest
from pydantic import ValidationError

from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions


def test_what_is_not_said_is_as_the_file_says() -> None:
    assert ImportOptions() == DEFAULT_OPTIONS
    assert (DEFAULT_OPTIONS.up, DEFAULT_OPTIONS.unit, DEFAULT_OPTIONS.origin) == (None, None, None)


@pytest.mark.parametrize(
    "wrong",
    [{"up": "x"}, {"unit": "km"}, {"origin": (0.0, 0.0)}, {"origin": (0.0, 0.0, float("nan"))}, {"variant": ""}],
    ids=str,
)
def test_what_no_file_can_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        ImportOptions.model_validate(wrong)


def test_texts_of_command_lines_and_addresses_are_read() -> None:
    assert ImportOptions.model_validate({"origin": "1.5,-2,3e5"}).origin == (1.5, -2.0, 3e5)
    assert ImportOptions.model_validate({"origin": ["1,2,3"]}).origin == (1.0, 2.0, 3.0)
    assert ImportOptions.model_validate({"origin": ["auto"]}).origin == "auto"
    assert ImportOptions.model_validate({"storeys": "ground, first"}).storeys == ("ground", "first")
    assert ImportOptions.model_validate({"storeys": ["ground, east"]}).storeys == ("ground, east",)


def test_options_come_back_from_json() -> None:
    options = ImportOptions(up="z", unit="mm", origin=(1, 2, 3), variant="oak", storeys=("a", "b"))
    assert ImportOptions.model_validate_json(options.model_dump_json()) == options
