"""What a user says of the light around a scene."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field


class EnvironmentOptions(BaseModel):
    """The picture that is around a scene, and how; without one, the scene has its own light."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    environment: Path | None = Field(
        default=None,
        description="picture of the light from all around, equirectangular, .hdr or .exr; its middle is towards +Z",
    )
    environment_rotation: float = Field(
        default=0.0, ge=-360.0, le=360.0, description="by which it is turned, counter-clockwise from above [degrees]"
    )
    environment_strength: float = Field(default=1.0, ge=0.0, le=1e6, description="factor of its radiance")


NO_ENVIRONMENT = EnvironmentOptions()
