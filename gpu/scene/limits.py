"""How large a scene may be, so that a file cannot take the machine's memory."""

from pydantic import BaseModel, ConfigDict, Field

MOST_BESIDE = 256  # files beside a scene's own whose times are remembered


class SceneLimits(BaseModel):
    """Limits on one scene. What exceeds one is refused with a SceneError before memory is taken for it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    max_file_bytes: int = Field(default=4 * 1024**3, ge=1, description="bytes of one file that a scene consists of")
    max_triangles: int = Field(default=20_000_000, ge=1, description="triangles, every instance counted")
    max_vertices: int = Field(default=60_000_000, ge=3, description="vertices, every instance counted")
    max_uv_sets: int = Field(default=8, ge=1, description="UV sets in use")
    max_materials: int = Field(default=65_536, ge=1, description="materials")
    max_lights: int = Field(default=4_096, ge=0, description="punctual lights")
    max_cameras: int = Field(default=4_096, ge=1, description="cameras")
    max_texture_size: int = Field(default=8_192, ge=1, description="pixels along one side of a texture")
    max_texture_pixels: int = Field(default=512 * 1024**2, ge=1, description="pixels of all textures together")


DEFAULT_LIMITS = SceneLimits()
