"""What a user says of how a file is to be read."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Axis = Literal["y", "z"]
Unit = Literal["m", "cm", "mm", "ft", "in"]
Name = Annotated[str, Field(min_length=1, max_length=256)]

METRES: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
"""The length of each unit."""


class ImportOptions(BaseModel):
    """How a file is read. What is None, or empty, is as the file says; where it says nothing, it is guessed."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    up: Axis | None = Field(default=None, description="which axis of the file points up")
    unit: Unit | None = Field(default=None, description="what one unit of length in the file is")
    origin: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        default=None, description="the point, in the file's own coordinates, that the scene's are counted from"
    )
    variant: Name | None = Field(default=None, description="which of the file's variants is shown")
    storeys: tuple[Name, ...] = Field(default=(), max_length=256, description="which of the file's storeys are shown")


DEFAULT_OPTIONS = ImportOptions()
