"""What can be chosen of a film: one model for the command line and REST."""

from enum import StrEnum

from pydantic import BaseModel, ConfigDict, Field

FILM_SUFFIX, FILM_TYPE = ".mp4", "video/mp4"


class FilmCodec(StrEnum):
    """How a video is compressed."""

    H264 = "h264"
    AV1 = "av1"


class Play(StrEnum):
    """What the animation of a scene does."""

    LOOP = "loop"
    ONCE = "once"
    NONE = "none"


class FilmSettings(BaseModel):
    """How a film shows the way of a camera, and what moves meanwhile."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    fps: int = Field(30, ge=1, le=120, description="pictures a second")
    codec: FilmCodec = Field(
        FilmCodec.H264, description="how an .mp4 is compressed: h264 plays everywhere, av1 is smaller"
    )
    play: Play = Field(
        Play.LOOP,
        description="what the scene's animation does: it begins anew at its end, stays there, or does not go on at all",
    )
