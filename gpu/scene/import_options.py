"""What a user says of how a file is to be read."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat

Axis = Literal["y", "z"]
Unit = Literal["m", "cm", "mm", "ft", "in"]
Name = Annotated[str, Field(min_length=1, max_length=256)]


def listed(value: Any) -> Any:
    """A text "a,b" as [a, b], as command lines have it."""
    return [part.strip() for part in value.split(",") if part.strip()] if isinstance(value, str) else value


def _point(value: Any) -> Any:
    if isinstance(value, list) and len(value) == 1:  # of an address
        value = value[0]
    parts = value if value in (None, "auto") else listed(value)
    if isinstance(parts, list | tuple) and len(parts) != 3:
        raise ValueError('needs three numbers "x,y,z", or "auto"')
    return parts


Point = tuple[FiniteFloat, FiniteFloat, FiniteFloat]

METRES: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
"""The length of each unit."""


class ImportOptions(BaseModel):
    """How a file is read. What is None, or empty, is as the file says; where it says nothing, it is guessed."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    up: Axis | None = Field(default=None, description="which axis of the file points up")
    unit: Unit | None = Field(default=None, description="what one unit of length in the file is")
    origin: Annotated[Point | Literal["auto"] | None, BeforeValidator(_point)] = Field(
        default=None,
        description='the point "x,y,z" of the file that metres of the scene are counted from; "auto" is its middle',
    )
    variant: Name | None = Field(default=None, description="which of the file's variants is shown")
    storeys: Annotated[tuple[Name, ...], BeforeValidator(listed)] = Field(
        default=(), max_length=256, description="which of the file's storeys are shown, comma-separated; all if none"
    )


DEFAULT_OPTIONS = ImportOptions()
