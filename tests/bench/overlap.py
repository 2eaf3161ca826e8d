"""Frames of several viewers at once: `python -m tests.bench.overlap [DEVICE] [SCENE …]`, a line of JSON a measurement.

Viewers walk through a scene, each its own way, with some numbers of lanes (gpu.core.lane) that they share evenly; as
many frames are under way as there are lanes, driven as a worker drives its jobs (server.worker.tasks), without
encoding. host_ms: the host's work a frame; frame_ms: from a frame's begin to its end; bit_equal: each viewer's pictures
are those it has alone.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from time import perf_counter
from zlib import crc32

import numpy as np

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.upload import DeviceScene
from gpu.film.frame import Frame
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.load import load_scene
from gpu.scene.types import Camera
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets
from server.worker.tasks import Tasks, Turn
from tests.bench.walk import APART_DEGREES, STEP_DEGREES

SCENES = ("living-room", "conference-room")
SIZES = ((320, 180), (480, 270), (640, 360))
LANES = (1, 2, 4, 8)
VIEWERS, WARM_UP, FRAMES, COMPARED = 16, 6, 40, 8


@dataclass(frozen=True)
class Place:
    """A scene that is walked through, at one size."""

    device_scene: DeviceScene
    light_sets: LightSets
    size: tuple[int, int]
    settings: RenderSettings

    def camera(self, viewer: int, number: int) -> Camera:
        """That of a viewer's frame: all look elsewhere, and turn."""
        first = self.device_scene.scene.cameras[0]
        return rotated(first, APART_DEGREES * viewer + STEP_DEGREES * number)


@dataclass
class Walker:
    """A viewer and where it is rendered; seconds, pictures: of its frames so far, and checksums of their radiance."""

    number: int
    renderer: Renderer
    view: ViewState
    frames: int = 0
    seconds: list[float] = field(default_factory=list)
    pictures: list[int] = field(default_factory=list)


class Crowd:
    """Viewers in some lanes; host_seconds: what the host did for all frames since the last `run` began."""

    def __init__(self, place: Place, viewers: range, lanes: int) -> None:
        device_scene, self._place = place.device_scene, place
        renderers = [
            Renderer(device_scene, place.size, place.settings, None, place.light_sets, Lane(device_scene.device))
            for _ in range(lanes)
        ]
        of = [renderers[index % lanes] for index in range(len(viewers))]
        self.walkers = [Walker(*it, it[1].new_view()) for it in zip(viewers, of, strict=True)]
        self._lanes, self.host_seconds = lanes, 0.0

    def run(self, frames: int, *, compares: bool = False) -> float:
        """Render so many more frames for each viewer, in turn; how long all took [s]."""
        tasks, host = Tasks(), 0.0
        wanted = self._in_turn(frames)
        busy: dict[int, Walker] = {}
        following = next(wanted, None)
        DEVICE_SHARING.begin(tasks)
        begun = perf_counter()
        try:
            for request in count(1):
                took = perf_counter()
                if (open_turn := tasks.ready()) is not None:
                    if tasks.resume(open_turn) is Turn.ENDED:
                        del busy[open_turn]
                elif following and len(busy) < self._lanes and self._is_free(following, busy):
                    busy[request] = following
                    if tasks.start(request, partial(self._frame, following, compares=compares)) is Turn.ENDED:
                        del busy[request]
                    following = next(wanted, None)
                elif busy:
                    continue  # the device has all it can be given
                else:
                    break
                host += perf_counter() - took
        finally:
            DEVICE_SHARING.begin(None)
        self.host_seconds = host
        return perf_counter() - begun

    def _in_turn(self, frames: int) -> Iterator[Walker]:
        return (walker for _ in range(frames) for walker in self.walkers)

    def _is_free(self, walker: Walker, busy: dict[int, Walker]) -> bool:
        return all(other.renderer is not walker.renderer for other in busy.values())

    def _frame(self, walker: Walker, *, compares: bool) -> None:
        begun = perf_counter()
        frame = self._rendered(walker)
        walker.seconds.append(perf_counter() - begun)
        if compares:
            walker.pictures.append(crc32(frame.radiance().tobytes()))

    def _rendered(self, walker: Walker) -> Frame:
        walker.frames += 1
        camera = self._place.camera(walker.number, walker.frames)
        return walker.renderer.render(camera, view=walker.view, walks=True)


def pictures(place: Place, viewers: range, lanes: int) -> list[list[int]]:
    """Checksums of the first frames of viewers who walk together."""
    crowd = Crowd(place, viewers, lanes)
    crowd.run(COMPARED, compares=True)
    return [walker.pictures for walker in crowd.walkers]


def measure(place: Place, viewers: int, lanes: int, alone: list[list[int]]) -> dict[str, object]:
    """One row; alone: what `pictures` are of each viewer without the others."""
    crowd = Crowd(place, range(viewers), lanes)
    crowd.run(WARM_UP)
    for walker in crowd.walkers:
        walker.seconds.clear()
    seconds, frames = crowd.run(FRAMES), FRAMES * viewers
    times = np.array([it for walker in crowd.walkers for it in walker.seconds])
    return {
        "size": list(place.size),
        "viewers": viewers,
        "lanes": lanes,
        "frames_a_second": round(frames / seconds, 1),
        "mpixels_a_second": round(1e-6 * frames * place.size[0] * place.size[1] / seconds, 2),
        "host_ms": round(1e3 * crowd.host_seconds / frames, 3),
        "median_frame_ms": round(1e3 * float(np.median(times)), 2),
        "p95_frame_ms": round(1e3 * float(np.quantile(times, 0.95)), 2),
        "bit_equal": pictures(place, range(viewers), lanes) == alone,
    }


def main(device: str, scenes: tuple[str, ...], settings: RenderSettings, viewers: int = VIEWERS) -> None:
    """Print a line for each scene, size and number of lanes."""
    for scene in scenes:
        device_scene = DeviceScene(load_scene(scene), device)
        light_sets = LightSets(device_scene)
        for size in SIZES:
            place = Place(device_scene, light_sets, size, settings)
            alone = [pictures(place, range(viewer, viewer + 1), 1)[0] for viewer in range(viewers)]
            for lanes in LANES:
                row = {"scene": scene, "device": device_scene.device.name, **measure(place, viewers, lanes, alone)}
                print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "cuda:0", tuple(sys.argv[2:]) or SCENES, RenderSettings())
