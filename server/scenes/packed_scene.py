"""A scene in a file between two processes: numbers as they lie in memory, all else as JSON, and nothing that could run.

Whoever wrote it read a user's file, so that it is checked like one.
"""

import json
import mmap
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from math import inf
from pathlib import PurePosixPath
from typing import Annotated, Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gpu.errors import SceneError
from gpu.scene.animation.motion import LIGHT_PROPERTIES, MATERIAL_PROPERTIES, Motion
from gpu.scene.file_frame import FileFrame
from gpu.scene.limits import MOST_BESIDE, SceneLimits
from gpu.scene.pauses import Pause, go_on
from gpu.scene.types import Camera, Light, LoadReport, Material, Placement, Rgb, Scene, Sky, Texture, Wrap
from gpu.scene.validate import (
    check_cameras,
    check_count,
    check_finite,
    check_indices,
    check_lights,
    check_materials,
    check_textures,
)
from server.scenes.packed_motion import PackedMotion, pack_motion, unpack_motion

_ARRAYS = ("vertices", "normals", "uvs", "triangles", "triangle_material", "vertex_object")
LENGTH_BYTES = 8  # before the JSON: how long that is
ALIGNMENT = 64  # of arrays [bytes]


class _Array(BaseModel):
    """An array as it lies in the file."""

    dtype: Literal["<f4", "<i4", "|u1", "<f8", "<i8"]
    shape: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)]


class _Texture(BaseModel):
    """A texture; pixels: the number of the array that has them."""

    name: str
    pixels: int
    srgb: bool
    wrap_s: Wrap
    wrap_t: Wrap
    nearest: bool


class _Camera(BaseModel):
    """A camera; to_world: 16 numbers, row by row."""

    name: str
    to_world: tuple[float, ...]
    half_height: float
    aspect: float
    orthographic: bool
    near: float


class _Header(BaseModel):
    """All of a scene but its arrays; arrays: the scene's by name, then pixels, then those of what moves."""

    model_config = ConfigDict(extra="forbid")

    name: str
    arrays: dict[str, _Array]
    pixels: tuple[_Array, ...]
    moving: tuple[_Array, ...]
    materials: tuple[Material, ...]
    textures: tuple[_Texture, ...]
    lights: tuple[Light, ...]
    sky: Sky | None
    cameras: tuple[_Camera, ...]
    placement: Placement
    bounds: tuple[Rgb, Rgb]
    report: LoadReport
    frame: FileFrame
    choices: dict[str, tuple[str, ...]]
    objects: tuple[str, ...]
    motion: PackedMotion | None


def write_scene(scene: Scene, file: BinaryIO) -> None:
    """Write a scene."""
    arrays = {name: getattr(scene, name) for name in _ARRAYS}
    if scene.colors is not None:
        arrays["colors"] = scene.colors
    pixels = list({id(texture.pixels): texture.pixels for texture in scene.textures}.values())
    places = {id(array): number for number, array in enumerate(pixels)}
    moving: dict[int, NDArray[Any]] = {}
    numbers: dict[int, int] = {}

    def number_of(array: NDArray[Any]) -> int:
        moving.setdefault(id(array), array)
        return numbers.setdefault(id(array), len(numbers))

    header = {name: getattr(scene, name) for name in _Header.model_fields if hasattr(scene, name)} | {
        "arrays": {name: _described(array) for name, array in arrays.items()},
        "pixels": [_described(array) for array in pixels],
        "textures": [_plain(texture) | {"pixels": places[id(texture.pixels)]} for texture in scene.textures],
        "cameras": [_plain(camera) | {"to_world": camera.to_world.ravel()} for camera in scene.cameras],
        "motion": scene.motion and pack_motion(scene.motion, number_of),
        "moving": [_described(array) for array in moving.values()],
    }
    text = json.dumps(header, default=_plain).encode()
    file.write(len(text).to_bytes(LENGTH_BYTES, "little") + text)
    place = LENGTH_BYTES + len(text)
    for array in (*arrays.values(), *pixels, *moving.values()):
        file.write(bytes(-place % ALIGNMENT))
        file.write(np.ascontiguousarray(array).data)
        place += -place % ALIGNMENT + array.nbytes


def read_scene(file: BinaryIO, source: str, limits: SceneLimits, pause: Pause = go_on) -> Scene:
    """The scene in a file that nobody writes any more, whose arrays stay there.

    pause: called between steps that take long. Raises SceneError where it is none, or none that is sound.
    """
    try:
        memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        scene = _unpacked(memory)
    except (ValueError, ValidationError, KeyError, IndexError) as error:
        raise SceneError(source, "", f"its reader left no scene: {error}") from None
    for _ in _check(scene, source, limits):
        pause()
    return scene


def _unpacked(memory: mmap.mmap) -> Scene:
    end = LENGTH_BYTES + int.from_bytes(memory[:LENGTH_BYTES], "little")
    header = _Header.model_validate_json(memory[LENGTH_BYTES:end])
    found: list[NDArray[Any]] = []
    for array in (*header.arrays.values(), *header.pixels, *header.moving):
        end += -end % ALIGNMENT
        count = int(np.prod(array.shape, dtype=np.int64))
        found.append(np.frombuffer(memory, array.dtype, count, end).reshape(array.shape))
        end += found[-1].nbytes
    arrays = dict(zip(header.arrays, found[: len(header.arrays)], strict=True))
    pixels = found[len(header.arrays) : len(header.arrays) + len(header.pixels)]
    moving = found[len(header.arrays) + len(header.pixels) :]
    return Scene(
        name=header.name,
        vertices=arrays["vertices"],
        normals=arrays["normals"],
        uvs=arrays["uvs"],
        colors=arrays.get("colors"),
        triangles=arrays["triangles"],
        triangle_material=arrays["triangle_material"],
        materials=header.materials,
        textures=tuple(Texture(**{**vars(texture), "pixels": pixels[texture.pixels]}) for texture in header.textures),
        lights=header.lights,
        sky=header.sky,
        cameras=tuple(
            Camera(**{**vars(camera), "to_world": np.array(camera.to_world).reshape(4, 4)}) for camera in header.cameras
        ),
        placement=header.placement,
        bounds=header.bounds,
        report=header.report,
        frame=header.frame,
        choices=header.choices,
        objects=header.objects,
        vertex_object=arrays["vertex_object"],
        motion=None if header.motion is None else unpack_motion(header.motion, moving),
    )


def _check(scene: Scene, source: str, limits: SceneLimits) -> Iterator[None]:
    """Raise SceneError for what does not hold of a scene that a device may have (gpu.scene.types.Scene), in steps."""
    vertices, triangles = len(scene.vertices), len(scene.triangles)
    check_count(source, "triangles", triangles, limits.max_triangles, "max_triangles")
    check_count(source, "vertices", vertices, limits.max_vertices, "max_vertices")
    shapes = {
        "vertices": (vertices, 3),
        "normals": (vertices, 3),
        "uvs": (len(scene.uvs), vertices, 2),
        "colors": (vertices, 4),
        "triangles": (triangles, 3),
        "triangle_material": (triangles,),
        "vertex_object": (vertices,),
    }
    for name, shape in shapes.items():
        values = getattr(scene, name)
        if name == "colors" and values is None:
            continue
        if values.shape != shape or (values.dtype == np.int32) != name.startswith(("triangle", "vertex_")):
            raise SceneError(source, name, f"its reader left {values.dtype} of shape {values.shape}, not {shape}")
        check_finite(source, name, values)
        yield
    check_indices(source, "triangles", scene.triangles, vertices)
    yield
    check_indices(source, "triangle_material", scene.triangle_material, len(scene.materials))
    yield
    check_indices(source, "vertex_object", scene.vertex_object, len(scene.objects))
    yield
    if scene.motion is not None:
        _check_motion(scene, scene.motion, source)
    check_textures(source, scene.textures, limits)
    check_materials(source, scene.materials, len(scene.textures), limits)
    check_lights(source, scene.lights, limits)
    check_cameras(source, scene.cameras, limits)
    placed = (*scene.placement.centre, scene.placement.scale, *scene.frame.origin, scene.frame.metres_per_unit)
    check_finite(source, "placement", np.array([placed]))
    beside = scene.report.beside
    if len(beside) > MOST_BESIDE or not all(map(_is_below, beside)):
        raise SceneError(source, "report", "its reader left files that it cannot have looked for")


def _is_below(name: str) -> bool:
    """Whether a name from a scene's folder is that of something in it."""
    path = PurePosixPath(name)
    return not path.is_absolute() and ".." not in path.parts


def _check_motion(scene: Scene, motion: Motion, source: str) -> None:
    """Raise SceneError where what moves is not of the scene, or two bodies have the same vertices."""
    begin = 0
    for body in motion.bodies:
        if body.first_vertex < begin:
            raise SceneError(source, "motion", "its reader left bodies that share vertices")
        begin = body.first_vertex + len(body.vertices)
    more = len(motion.lights) > len(scene.lights) or len(motion.cameras) > len(scene.cameras)
    there = dict.fromkeys(MATERIAL_PROPERTIES, len(scene.materials)) | dict.fromkeys(
        LIGHT_PROPERTIES, len(scene.lights)
    )
    channels = (channel for animation in motion.animations for channel in animation.channels)
    more = more or any(channel.part >= there.get(channel.changes, inf) for channel in channels)
    if begin > len(scene.vertices) or more:
        raise SceneError(source, "motion", "its reader left more that moves than there is")


def _described(array: NDArray[Any]) -> dict[str, Any]:
    return {"dtype": array.dtype.str, "shape": array.shape}


def _plain(value: Any) -> Any:
    """What JSON has no word for, as what it has."""
    if is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else list(value)
