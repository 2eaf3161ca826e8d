"""Frames of several viewers at once: `python -m tests.bench.overlap [DEVICE] [SCENE …]`, a line of JSON a measurement.

Viewers walk through a scene, each its own way, with some numbers of lanes (gpu.core.lane) that they share evenly, and
of viewers whose pictures are tiles of one frame (gpu.tiled_frames). As many frames are under way as there are lanes,
driven as a worker drives its jobs (server.worker.tasks), without encoding. host_ms: the host's work a picture;
frame_ms: from a frame's begin to its end; bit_equal: each viewer's pictures are those it has alone; difference: relMSE
between both; of_seeds: between those that the first viewer has alone by one seed and by another.
"""

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count, cycle
from time import perf_counter

import numpy as np

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.upload import DeviceScene
from gpu.film.frame import Frame
from gpu.film.metrics import rel_mse
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.load import load_scene
from gpu.scene.types import Camera, Floats
from gpu.settings import RenderSettings
from gpu.tiled_frames import TiledFrames
from gpu.vpl.light_sets import LightSets
from server.worker.tasks import Tasks, Turn
from tests.bench.walk import APART_DEGREES, STEP_DEGREES

SCENES = ("living-room", "conference-room")
Sizes = tuple[tuple[int, int], ...]
SIZES: Sizes = ((320, 180), (480, 270), (640, 360))
# Lanes, and tiles of each frame.
WAYS = ((1, 1), (2, 1), (4, 1), (8, 1), (1, 4), (4, 4), (1, 16))
VIEWERS, WARM_UP, FRAMES, COMPARED, OTHER_SEED = 16, 6, 40, 8, 5

Pictures = dict[int, list[Floats]]  # by viewer


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

    def renderer(self, tiles: int, lane: Lane) -> Renderer:
        """One of so many tiles, in a lane."""
        return Renderer(self.device_scene, self.size, self.settings, None, self.light_sets, lane, tiles)


@dataclass
class Party:
    """Viewers who have frames together, and where; seconds: of these so far; pictures: kept of them."""

    viewers: range
    lane: int
    render: Callable[[dict[int, Camera]], dict[int, Frame]]
    frames: int = 0
    seconds: list[float] = field(default_factory=list)
    pictures: Pictures = field(default_factory=dict)


class Crowd:
    """Viewers in some lanes; host_seconds: what the host did for all frames since the last `run` began."""

    def __init__(self, place: Place, viewers: range, lanes: int, tiles: int = 1) -> None:
        self._place, self.host_seconds = place, 0.0
        all_lanes = [Lane(place.device_scene.device) for _ in range(lanes)]
        parties = [viewers[begin : begin + tiles] for begin in range(0, len(viewers), tiles)]
        renders: list[Callable[[dict[int, Camera]], dict[int, Frame]]]
        if tiles > 1:
            chosen = zip(cycle(all_lanes), parties, strict=False)
            renders = [TiledFrames(place.renderer(tiles, lane)).render for lane, _ in chosen]
        else:
            renderers = [place.renderer(1, lane) for lane in all_lanes]
            renders = [partial(_alone, of, of.new_view()) for of, _ in zip(cycle(renderers), parties, strict=False)]
        self.parties = [Party(it, index % lanes, renders[index]) for index, it in enumerate(parties)]

    def run(self, frames: int, *, compares: bool = False) -> float:
        """Render so many more frames for each viewer, in turn; how long all took [s]."""
        tasks, host = Tasks(), 0.0
        wanted = self._in_turn(frames)
        busy: dict[int, Party] = {}
        following = next(wanted, None)
        DEVICE_SHARING.begin(tasks)
        begun = perf_counter()
        try:
            for request in count(1):
                took = perf_counter()
                if (open_turn := tasks.ready()) is not None:
                    if tasks.resume(open_turn) is Turn.ENDED:
                        del busy[open_turn]
                elif following and all(other.lane != following.lane for other in busy.values()):
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

    def _in_turn(self, frames: int) -> Iterator[Party]:
        return (party for _ in range(frames) for party in self.parties)

    def _frame(self, party: Party, *, compares: bool) -> None:
        begun = perf_counter()
        party.frames += 1
        frames = party.render({viewer: self._place.camera(viewer, party.frames) for viewer in party.viewers})
        party.seconds.append(perf_counter() - begun)
        for viewer, frame in frames.items() if compares else ():
            party.pictures.setdefault(viewer, []).append(frame.radiance())


def _alone(renderer: Renderer, view: ViewState, cameras: dict[int, Camera]) -> dict[int, Frame]:
    """The next picture of the only viewer among them."""
    return {viewer: renderer.render(camera, view=view, walks=True) for viewer, camera in cameras.items()}


def pictures(place: Place, viewers: range, lanes: int = 1, tiles: int = 1) -> Pictures:
    """The first frames of viewers who walk together."""
    crowd = Crowd(place, viewers, lanes, tiles)
    crowd.run(COMPARED, compares=True)
    return {viewer: found for party in crowd.parties for viewer, found in party.pictures.items()}


def difference(found: Pictures, expected: Pictures) -> float:
    """RelMSE between pictures, in the mean over all."""
    pairs = [pair for viewer in found for pair in zip(found[viewer], expected[viewer], strict=True)]
    return float(np.mean([rel_mse(*pair) for pair in pairs]))


def measure(place: Place, viewers: int, way: tuple[int, int], alone: Pictures) -> dict[str, object]:
    """One row; way: lanes and tiles; alone: what `pictures` are of each viewer without the others."""
    crowd = Crowd(place, range(viewers), *way)
    crowd.run(WARM_UP)
    for party in crowd.parties:
        party.seconds.clear()
    seconds, frames = crowd.run(FRAMES), FRAMES * viewers
    times = np.array([it for party in crowd.parties for it in party.seconds])
    off = difference(pictures(place, range(viewers), *way), alone)
    return {
        "size": list(place.size),
        "viewers": viewers,
        "lanes": way[0],
        "tiles": way[1],
        "frames_a_second": round(frames / seconds, 1),
        "mpixels_a_second": round(1e-6 * frames * place.size[0] * place.size[1] / seconds, 2),
        "host_ms": round(1e3 * crowd.host_seconds / frames, 3),
        "median_frame_ms": round(1e3 * float(np.median(times)), 2),
        "p95_frame_ms": round(1e3 * float(np.quantile(times, 0.95)), 2),
        "bit_equal": off == 0.0,
        "difference": off,
    }


def main(
    device: str, scenes: tuple[str, ...], settings: RenderSettings, viewers: int = VIEWERS, sizes: Sizes = SIZES
) -> None:
    """Print a line for each scene, size and way to render together."""
    for scene in scenes:
        device_scene = DeviceScene(load_scene(scene), device)
        light_sets = LightSets(device_scene)
        for size in sizes:
            place = Place(device_scene, light_sets, size, settings)
            alone: Pictures = {}
            for viewer in range(viewers):
                alone |= pictures(place, range(viewer, viewer + 1))
            other = replace(place, settings=settings.model_copy(update={"seed": OTHER_SEED}))
            of_seeds = difference(pictures(other, range(1)), alone)
            for way in WAYS:
                row = {"scene": scene, "device": device_scene.device.name, **measure(place, viewers, way, alone)}
                print(json.dumps({**row, "of_seeds": of_seeds}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "cuda:0", tuple(sys.argv[2:]) or SCENES, RenderSettings())
