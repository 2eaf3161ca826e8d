"""What of a scene moves, in a file between two processes (server.scenes.packed_scene): arrays as they lie in memory,
which the rest names by their numbers. Whoever wrote it read a user's file, so that it is checked like one.
"""

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from gpu.scene.animation.moment import AnimationId
from gpu.scene.animation.motion import (
    COMPONENTS,
    NODE_PROPERTIES,
    STILL,
    Animation,
    Body,
    Channel,
    Interpolation,
    MorphTarget,
    Motion,
    Property,
    Skin,
)

_Number = Annotated[int, Field(ge=0)]
_Node = Annotated[int, Field(ge=STILL)]


class _Packed(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Channel(_Packed):
    part: _Number
    changes: Property
    interpolation: Interpolation
    times: _Number
    values: _Number


class _Animation(_Packed):
    id: AnimationId
    seconds: Annotated[FiniteFloat, Field(ge=0.0)]
    channels: Annotated[tuple[_Channel, ...], Field(min_length=1)]


class _Skin(_Packed):
    joints: _Number
    inverse: _Number


class _MorphTarget(_Packed):
    positions: _Number | None
    normals: _Number | None


class _Body(_Packed):
    node: _Number
    positions: _Number
    normals: _Number | None
    triangles: _Number
    instances: _Number
    targets: tuple[_MorphTarget, ...]
    weights: tuple[FiniteFloat, ...]
    skin: _Skin | None
    joints: _Number
    shares: _Number
    first_vertex: _Number
    vertices: _Number


class PackedMotion(_Packed):
    """A `Motion` with numbers in the place of arrays."""

    parents: _Number
    local: _Number
    rest: _Number
    animations: Annotated[tuple[_Animation, ...], Field(min_length=1, max_length=256)]
    bodies: tuple[_Body, ...]
    lights: tuple[_Node, ...]
    cameras: tuple[_Node, ...]
    intensity_scale: Annotated[FiniteFloat, Field(gt=0.0)]


def pack_motion(motion: Motion, number_of: Callable[[NDArray[Any]], int]) -> Any:
    """`motion` in the form of `PackedMotion`, in JSON's types; number_of: of an array, which is written elsewhere."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return number_of(value)
        if is_dataclass(value):
            return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
        return [plain(item) for item in value] if isinstance(value, tuple) else value

    return plain(motion)


def unpack_motion(packed: PackedMotion, arrays: Sequence[NDArray[Any]]) -> Motion:
    """The motion that was packed. Raises ValueError, or IndexError, for one that no reader would leave."""
    found = _Arrays(arrays)
    parents = found.take(packed.parents, "<i4", None)
    nodes = len(parents)
    if not (parents >= STILL).all() or not (parents < np.arange(nodes)).all():
        raise ValueError("nodes do not come after what they are in")
    if max((STILL, *packed.lights, *packed.cameras)) >= nodes:
        raise ValueError("a light or a camera hangs on no node")
    return Motion(
        parents,
        found.take(packed.local, "<f8", nodes, 4, 4),
        found.take(packed.rest, "<f8", nodes, 10),
        tuple(
            Animation(one.id, one.seconds, tuple(_channel(it, found, nodes) for it in one.channels))
            for one in packed.animations
        ),
        tuple(_body(body, found, nodes) for body in packed.bodies),
        packed.lights,
        packed.cameras,
        packed.intensity_scale,
    )


class _Arrays:
    def __init__(self, arrays: Sequence[NDArray[Any]]) -> None:
        self._arrays = arrays

    def take(self, number: int, dtype: str, *shape: int | None) -> NDArray[Any]:
        """An array of that type and shape (None: whatever it is), all finite."""
        array = self._arrays[number]
        if array.dtype.str != dtype or len(array.shape) != len(shape):
            raise ValueError(f"{array.dtype.str} of shape {array.shape} in what moves")
        if any(want not in (None, have) for want, have in zip(shape, array.shape, strict=True)):
            raise ValueError(f"shape {array.shape} in what moves, not {shape}")
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError("what moves is not finite")
        return array

    def indices(self, number: int, dtype: str, below: int, *shape: int | None) -> NDArray[Any]:
        """As `take`, of indices `below` a number."""
        array = self.take(number, dtype, *shape)
        if array.size and not 0 <= int(array.min()) <= int(array.max()) < below:
            raise ValueError("what moves refers to what is not there")
        return array


def _channel(packed: _Channel, found: _Arrays, nodes: int) -> Channel:
    times = found.take(packed.times, "<f8", None)
    parts = 3 if packed.interpolation is Interpolation.CUBICSPLINE else 1
    values = found.take(packed.values, "<f8", len(times), parts, COMPONENTS[packed.changes])
    nowhere = packed.changes in NODE_PROPERTIES and packed.part >= nodes
    if nowhere or not len(times) or (np.diff(times) < 0.0).any():
        raise ValueError("a channel has no node, no keys, or keys that go back")
    return Channel(packed.part, packed.changes, packed.interpolation, times, values)


def _body(packed: _Body, found: _Arrays, nodes: int) -> Body:
    positions = found.take(packed.positions, "<f8", None, 3)
    count = len(positions)
    instances = found.take(packed.instances, "<f8", None, 4, 4)
    if packed.node >= nodes:
        raise ValueError("a mesh hangs on no node")
    skin, joints = None, found.take(packed.joints, "<i4", None, None)
    if packed.skin is not None:
        own = found.indices(packed.skin.joints, "<i4", nodes, None)
        skin = Skin(own, found.take(packed.skin.inverse, "<f8", len(own), 4, 4))
        joints = found.indices(packed.joints, "<i4", len(own), count, None)
    placed = count if skin is not None else count * len(instances)
    return Body(
        packed.node,
        positions,
        None if packed.normals is None else found.take(packed.normals, "<f8", count, 3),
        found.indices(packed.triangles, "<i8", count, None, 3),
        instances,
        tuple(
            MorphTarget(
                *(None if it is None else found.take(it, "<f8", count, 3) for it in (target.positions, target.normals))
            )
            for target in packed.targets
        ),
        packed.weights,
        skin,
        joints,
        found.take(packed.shares, "<f8", *joints.shape),
        packed.first_vertex,
        found.indices(packed.vertices, "<i4", placed, None),
    )
