"""What a render request says, for stills and for jobs alike."""

import math
from math import ceil
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, FiniteFloat, StrictInt, Tag, field_validator

from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from server.render.turns import samples_a_turn
from server.wire.browser import Matrix, SceneId, Size, check_rigid
from server.wire.worker import CameraMatrix, CameraSpec, LookAt, Output, Render, SceneCamera, SceneRef

# Samples a pixel of one frame of a method that refines by samples, at most.
SAMPLES_A_FRAME = 64

Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Degrees = Annotated[float, Field(gt=0.5, lt=178.0, description="vertical field of view [°]")]


class Strict(BaseModel):
    """Base of request bodies."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class LookAtCamera(Strict):
    """A view from a point towards another, in the coordinates of the scene's file."""

    position: Vector
    target: Vector
    up: Vector | None = Field(default=None, description="what points up in the picture; the scene's up if left out")
    yfov_degrees: Degrees = 60.0


class MatrixCamera(Strict):
    """A view by its camera-to-world matrix: 16 numbers, column after column, looking along −Z with +Y up.

    The world is in metres with +Y up, counted from the scene's origin: `frame` of the scene says where that is.
    """

    matrix: Matrix
    yfov_degrees: Degrees = 60.0
    near: float = Field(0.0, ge=0.0, lt=1e30, description="what is less far in front of the camera is cut away [m]")

    @field_validator("matrix")
    @classmethod
    def _rigid(cls, matrix: tuple[float, ...]) -> tuple[float, ...]:
        check_rigid(matrix)
        return matrix


def _camera_form(camera: Any) -> str:
    if isinstance(camera, str):
        return "name"
    if isinstance(camera, dict):
        return "matrix" if "matrix" in camera else "look-at"
    if isinstance(camera, MatrixCamera):
        return "matrix"
    return "look-at" if isinstance(camera, LookAtCamera) else "index"


CameraChoice = Annotated[
    Annotated[StrictInt, Tag("index"), Field(ge=0)]
    | Annotated[str, Tag("name"), Field(max_length=512)]
    | Annotated[LookAtCamera, Tag("look-at")]
    | Annotated[MatrixCamera, Tag("matrix")],
    Discriminator(_camera_form),
]


class RenderRequest(Strict):
    """A still; what is left out gets its default."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"size": [640, 360]},
                {
                    "camera": {"position": [0.0, 1.0, 3.0], "target": [0.0, 1.0, 0.0], "yfov_degrees": 45.0},
                    "size": [320, 180],
                    "settings": {"method": "path", "samples": 16},
                },
            ]
        }
    )

    scene: SceneId | None = Field(default=None, description="scene id; the served scene when not given")
    scene_options: ImportOptions | None = Field(
        default=None, description="how its file is read; as the service does when not given"
    )
    camera: CameraChoice = Field(default=0, description="one of the scene's by index or name, or one of your own")
    size: Size = Field(default=(1280, 720), description="width and height [px]")
    settings: RenderSettings = Field(
        default=RenderSettings(),
        description="method and quality; `frames` are averaged (1 when not given), and so are frames of fewer "
        "samples where those asked for would take the device from others for long",
    )

    def view(self) -> CameraSpec:
        """The camera as the worker takes it."""
        match self.camera:
            case LookAtCamera(position=position, target=target, up=up, yfov_degrees=yfov):
                return LookAt(position, target, up, yfov)
            case MatrixCamera(matrix=matrix, yfov_degrees=yfov, near=near):
                return CameraMatrix(matrix, math.radians(yfov), near)
            case camera:
                return SceneCamera(camera)

    def frames(self) -> tuple[int, RenderSettings]:
        """How many frames the picture is the mean of, each a turn of its own, and the settings of each."""
        settings, frames = self.settings, self.settings.frames or 1
        if settings.samples is not None:
            most = samples_a_turn(settings, self.size)
            pieces = ceil(
                settings.samples / (min(most, SAMPLES_A_FRAME) if settings.method.refines_by_samples else most)
            )
            settings = settings.model_copy(update={"samples": ceil(settings.samples / pieces)})
            frames *= pieces
        return frames, settings.model_copy(update={"frames": None})

    def weight(self) -> int:
        """The work of the picture, in frames of as many samples as are usual at most."""
        return (self.settings.frames or 1) * ceil((self.settings.samples or 1) / SAMPLES_A_FRAME)

    def render(self, viewer: int, scene: SceneRef, output: Output) -> Render:
        """The order to the worker for one frame of it."""
        return Render(viewer, scene, self.view(), self.size, self.frames()[1], output)
