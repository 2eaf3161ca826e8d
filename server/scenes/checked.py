"""What a child that reads a scene is asked, and what it answers: all that it loads of the service besides readers."""

from pydantic import BaseModel, ConfigDict

from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from server.wire.browser import SceneInfo


class SceneSize(BaseModel):
    """How much of everything a scene has; `texels` counts pixels that several textures share once."""

    model_config = ConfigDict(frozen=True)

    vertices: int
    triangles: int
    uv_sets: int
    colored: bool
    materials: int
    texels: int


class CheckRequest(BaseModel):
    """What a child is to read: a built-in name or a file, which is an archive if there is a folder to unpack it in.

    in_environment: as of server.scenes.scene_info.describe_scene. result: the descriptor of an open file that gets the
    scene itself (server.scenes.packed_scene), as its file has it, if it is wanted.
    """

    source: str
    folder: str | None
    limits: SceneLimits
    max_unpacked_bytes: int
    memory_bytes: int
    seconds: float
    options: ImportOptions = DEFAULT_OPTIONS
    in_environment: bool = False
    result: int | None = None


class Checked(BaseModel):
    """A sound scene. source: the scene itself, which for an archive is a file in the folder."""

    model_config = ConfigDict(frozen=True)

    source: str
    info: SceneInfo
    size: SceneSize


class Refused(BaseModel):
    """What is wrong with a scene: the place in it, and the problem; of an archive that is too large, its size."""

    field: str
    problem: str
    unpacked_bytes: int | None = None
