from argparse import ArgumentError, ArgumentParser
from enum import StrEnum

import pytest
from pydantic import BaseModel, Field

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.cli.options import add_options, given_options, model_from


class Colour(StrEnum):
    RED = "red"
    BLUE = "blue"


class Inner(BaseModel):
    depth: int = 1


class Switches(BaseModel):
    one: bool = True
    other: bool = True


class Example(BaseModel):
    light_count: int = Field(4, ge=1, le=8, description="how many")
    share: float | None = Field(None, gt=0.0, description="100 % or less")
    colour: Colour = Field(Colour.RED, description="which")
    loud: bool = False
    inner: Inner = Inner()
    leave_out: Switches = Field(Switches(), description="what is left out")


def parser(model: type[BaseModel]) -> ArgumentParser:
    result = ArgumentParser(exit_on_error=False)
    add_options(result, model, "options")
    return result


def test_options_become_typed_fields() -> None:
    options = parser(Example).parse_args(["--light-count", "2", "--share=0.5", "--colour", "blue", "--loud"])
    assert model_from(options, Example) == Example(light_count=2, share=0.5, colour=Colour.BLUE, loud=True)


def test_what_is_not_given_is_left_to_the_model() -> None:
    assert given_options(parser(Example).parse_args([]), Example) == {}
    assert given_options(parser(Example).parse_args(["--no-loud"]), Example) == {"loud": False}


def test_help_says_limits_choices_and_defaults() -> None:
    text = " ".join(parser(Example).format_help().split())
    assert "how many (1 to 8; default 4)" in text
    assert "100 % or less (above 0)" in text
    assert "{red,blue}" in text
    assert "(default red)" in text
    assert "--inner" not in text


def test_switches_are_named_to_be_off() -> None:
    options = parser(Example).parse_args(["--no-leave-out", "other"])
    assert model_from(options, Example).leave_out == Switches(other=False)
    options = parser(Example).parse_args(["--no-leave-out", "one,other"])
    assert model_from(options, Example).leave_out == Switches(one=False, other=False)
    assert "without what is left out: one, other; comma-separated" in " ".join(parser(Example).format_help().split())
    with pytest.raises(ArgumentError, match="'none' is none of one, other"):
        parser(Example).parse_args(["--no-leave-out", "one,none"])


@pytest.mark.parametrize("words", [["--light-count", "9"], ["--light-count", "many"], ["--share", "0"]])
def test_a_wrong_value_is_named(words: list[str]) -> None:
    with pytest.raises(UserError, match=f"^{words[0]}: .*{words[1]}"):
        model_from(parser(Example).parse_args(words), Example)


def test_every_render_setting_is_an_option() -> None:
    text = parser(RenderSettings).format_help()
    names = [name.replace("_", "-") for name in RenderSettings.model_fields]
    assert all(f"--{name}" in text or f"--no-{name}" in text for name in names)
