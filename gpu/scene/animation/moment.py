"""When it is in a scene that has animations: what a user can choose of it."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

AnimationId = Annotated[str, Field(min_length=1, max_length=96)]


class Moment(BaseModel):
    """A time of an animation."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: FiniteFloat | None = Field(
        default=None,
        ge=0.0,
        le=1e6,
        description="seconds into an animation of the scene, which stays at its end; without, as the file poses it",
    )
    animation: AnimationId | None = Field(
        default=None, description="the animation that the time is of, by its id; without, the first"
    )
