from typing import Literal

import pytest
from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, ValidationError, field_validator

from server.refusals import reason


class Ball(BaseModel):
    kind: Literal["ball"]


class Box(BaseModel):
    kind: Literal["box"]


class Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")

    count: int = Field(ge=1)
    day: AwareDatetime | None = None
    sides: tuple[int, ...] = Field((1, 1), min_length=2, max_length=3)
    name: str = Field("box", min_length=1)
    form: Ball | Box | None = Field(None, discriminator="kind")

    @field_validator("count")
    @classmethod
    def even(cls, value: int) -> int:
        if value % 2:
            raise ValueError("is odd; double it")
        return value


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"count": 2, "side": 3}, "is not known here; check its name"),
        ({"count": 2, "sides": [1]}, "needs 2 or more, has 1"),
        ({"count": 2, "sides": [1, 2, 3, 4]}, "may have 3 or fewer, has 4"),
        ({"count": 2, "sides": 1}, "must be an array"),
        ({"count": 2, "name": ""}, "must have at least 1 character"),
        ({"count": 2, "form": {}}, "'kind' is missing"),
        ({"count": 2, "form": {"kind": "cube"}}, "'kind' must be one of 'ball', 'box', not 'cube'"),
        ({}, "is missing"),
        ({"count": 3}, "is odd; double it"),
        ({"count": 2, "day": "2026-06-21T12:00"}, "must have timezone info"),
        ({"count": 0}, "must be greater than or equal to 1"),
    ],
)
def test_what_is_wrong_with_a_field_is_said_in_plain_words(given: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError) as caught:
        Asked.model_validate(given)
    assert reason(caught.value.errors()[0]) == words
