"""The way of a film's camera, as files and requests have it.

    {"keyframes": [
        {"time": 0, "camera": {"position": [0, 1.6, 3], "target": [0, 1.6, 0], "yfov_degrees": 50}, "name": "hall"},
        {"time": 2.5, "camera": "door"},
        {"time": 6, "camera": 0}
    ]}

Times are seconds, increasing; a camera is written as that of a still over REST. What the camera does in between is in
gpu.scene.camera_path.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, overload

from pydantic import Field, FiniteFloat, field_validator
from pydantic_core import PydanticCustomError

from gpu.errors import UserError
from server.wire.browser import Message
from server.wire.cameras import CameraChoice, view_of
from server.wire.worker import AlongPath, View

MAX_KEYFRAMES, MAX_SECONDS = 200, 3600.0
MAX_PICTURES = 36_000  # of a film


class Keyframe(Message):
    """A view that the camera passes at its time."""

    time: Annotated[FiniteFloat, Field(ge=0.0, le=MAX_SECONDS, description="[s]")]
    camera: CameraChoice = Field(description="one of the scene's by index or name, or one of your own")
    name: str = Field(default="", max_length=512, description="of the view, for people")


class CameraPathSpec(Message):
    """Keyframes in the order of their times; the film lasts from the first to the last."""

    keyframes: Annotated[tuple[Keyframe, ...], Field(min_length=2, max_length=MAX_KEYFRAMES)]

    @field_validator("keyframes")
    @classmethod
    def _in_order(cls, keyframes: tuple[Keyframe, ...]) -> tuple[Keyframe, ...]:
        for index, (before, after) in enumerate(pairwise(keyframes), 1):
            if after.time <= before.time:
                words = {"index": index, "time": f"{after.time:g}", "before": f"{before.time:g}"}
                raise PydanticCustomError("order", "times must increase; [{index}] has {time} after {before}", words)
        return keyframes

    @property
    def seconds(self) -> float:
        """How long the film is."""
        return self.keyframes[-1].time - self.keyframes[0].time

    def views(self, fps: int) -> Sequence[AlongPath]:
        """The view of each picture of the film, the first at the first keyframe; UserError where they are too many."""
        count = max(1, round(self.seconds * fps))
        if count > MAX_PICTURES:
            raise UserError(
                f"keyframes: {self.seconds:g} s are {count} pictures at {fps} a second, more than the {MAX_PICTURES} "
                "of a film; make it shorter, or take fewer a second"
            )
        return _Views(tuple((it.time, view_of(it.camera)) for it in self.keyframes), range(count), fps)


@dataclass(frozen=True)
class _Views(Sequence[AlongPath]):
    """Views of pictures by their numbers, each made when it is asked for: all of a film would take long."""

    keyframes: tuple[tuple[float, View], ...]
    numbers: range
    fps: int

    def __len__(self) -> int:
        return len(self.numbers)

    @overload
    def __getitem__(self, index: int) -> AlongPath: ...

    @overload
    def __getitem__(self, index: slice) -> "_Views": ...

    def __getitem__(self, index: int | slice) -> "AlongPath | _Views":
        if isinstance(index, slice):
            return replace(self, numbers=self.numbers[index])
        return AlongPath(self.keyframes, self.keyframes[0][0] + self.numbers[index] / self.fps)
