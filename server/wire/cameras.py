"""Cameras as clients and files write them: one of the scene's, or one of their own."""

import math
from typing import Annotated, Any

from pydantic import Discriminator, Field, FiniteFloat, StrictInt, Tag, field_validator

from server.wire.browser import Matrix, Message, check_rigid
from server.wire.worker import CameraMatrix, LookAt, SceneCamera, View

Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Degrees = Annotated[float, Field(gt=0.5, lt=178.0, description="vertical field of view [°]")]
Near = Annotated[float, Field(ge=0.0, lt=1e30, description="what is less far in front of the camera is cut away [m]")]


class LookAtCamera(Message):
    """A view from a point towards another, in the coordinates of the scene's file."""

    position: Vector
    target: Vector
    up: Vector | None = Field(default=None, description="what points up in the picture; the scene's up if left out")
    yfov_degrees: Degrees = 60.0
    near: Near = 0.0


class MatrixCamera(Message):
    """A view by its camera-to-world matrix: 16 numbers, column after column, looking along −Z with +Y up.

    The world is in metres with +Y up, counted from the scene's origin: `frame` of the scene says where that is.
    """

    matrix: Matrix
    yfov_degrees: Degrees = 60.0
    near: Near = 0.0

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


def view_of(camera: int | str | LookAtCamera | MatrixCamera) -> View:
    """A choice of camera as the worker takes it."""
    match camera:
        case LookAtCamera(position=position, target=target, up=up, yfov_degrees=yfov, near=near):
            return LookAt(position, target, up, yfov, near)
        case MatrixCamera(matrix=matrix, yfov_degrees=yfov, near=near):
            return CameraMatrix(matrix, math.radians(yfov), near)
        case choice:
            return SceneCamera(choice)
