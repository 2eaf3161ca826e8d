"""What is learnt of one viewer's frames whose counts of clusters follow a wanted time or error."""

from collections import deque
from dataclasses import dataclass, field
from math import pi, sin
from statistics import median
from typing import Any

from gpu.adaptive.error_probes import Probes
from gpu.adaptive.governor import Governor
from gpu.adaptive.levels import Level
from gpu.scene.camera import rotated
from gpu.scene.types import Camera


@dataclass(frozen=True)
class SteeringParameters:
    """Which frames tell what, and how many there are.

    walk_aim: share of a wanted time that walks aim at: theirs grow unforeseen more often than they fall, by what is new
    in a view, and by what else the host does. first_of_lights: frames of a walk with other lights than before until
    they take what those that follow do. most_tries: of a frame with a wanted error.
    settling_frames: that nobody sees, until the counts of the first picture meet its target, at most. In those of a
    walk the camera sways, sway_degrees to either side and sway_frames to and fro, as fast as walkers turn: frames that
    see nothing new would take less than others. host_frames: of so many the median tells what the host takes, which
    varies more than what a device does.
    """

    walk_aim: float = 0.98
    first_of_lights: int = 4
    most_tries: int = 8
    settling_frames: int = 32
    sway_degrees: float = 4.0
    sway_frames: int = 16
    host_frames: int = 15


STEERING_PARAMETERS = SteeringParameters()


@dataclass
class Steering:
    """What is known of a viewer's frames, apart for those of a walk and others where they are governed apart.

    level: the last frame's; applied: whether its clustering knows of it; wants_retry: whether the next frame is another
    try at the last one, is_retry: whether the last one was, of the same lights; unlike: how many frames from the last
    one on are unlike those that follow in a walk; host_ms: what frames of a walk, and others, took beside
    their stages, learning_ms: and learning of the last one.
    """

    level: Level
    probes: Probes | None
    governors: dict[bool, Governor[Any]] = field(default_factory=dict)
    settled: set[bool] = field(default_factory=set)
    applied: bool = False
    wants_retry: bool = False
    is_retry: bool = False
    unlike: int = 0
    host_ms: dict[bool, deque[float]] = field(
        default_factory=lambda: {walks: deque([0.0], STEERING_PARAMETERS.host_frames) for walks in (False, True)}
    )
    learning_ms: float = 0.0

    def begin_frame(self, *, walks: bool) -> None:
        """One more frame at the same level, which is no other try."""
        self.unlike = max(self.unlike - 1, 0) if walks else 0
        self.is_retry = False

    def change(self, level: Level, *, walks: bool, retries: bool) -> None:
        """The frame that was begun has another `level`; retries: it is another try."""
        relights = level.vpl_clusters != self.level.vpl_clusters
        if walks and relights:
            self.unlike = STEERING_PARAMETERS.first_of_lights
        elif walks and level.sp_clusters != self.level.sp_clusters:
            self.unlike = max(self.unlike, 1)
        self.level, self.applied, self.is_retry = level, False, retries and not relights

    def host_time(self, taken_ms: float | None, *, walks: bool) -> float:
        """What the host takes beside a frame's stages and learning of it [ms]; taken_ms: for the last one, if known."""
        if taken_ms is not None:
            self.host_ms[walks].append(taken_ms + self.learning_ms)
        return median(self.host_ms[walks])


def swayed(camera: Camera, number: int) -> Camera:
    """`camera` in frame `number` of those that nobody sees."""
    return rotated(
        camera, STEERING_PARAMETERS.sway_degrees * sin(2.0 * pi * (number + 1) / STEERING_PARAMETERS.sway_frames)
    )
