"""Who has a frame with whom; frames are on their way until the sky is open."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gpu.core.sharing import DEVICE_SHARING
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.tiled_frames import MOST_ABSENT
from server.worker.table import FRAME_PIXELS, MOST_TILES, LostFrameError, Table, tiles_of
from server.worker.tasks import CancelledError, Tasks, Turn

TILES = 3
CAMERA = look_at((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


class SlowRenderer:
    """Its frames say which tiles somebody looks at, once they are over."""

    tiles = TILES

    def __init__(self) -> None:
        self.over, self.error = True, RuntimeError("an illegal access")
        self.fails = False
        self.frames: list[list[int]] = []

    def new_view(self) -> Any:
        return SimpleNamespace(walks=[SimpleNamespace(last=None) for _ in range(TILES)])

    def render_tiles(self, cameras: Sequence[Any], view: Any) -> list[Any]:
        for walk, camera in zip(view.walks, cameras, strict=True):
            walk.last = camera
        watched = [tile for tile, camera in enumerate(cameras) if camera is not None]
        self.frames.append(watched)
        DEVICE_SHARING.leave_until(lambda: self.over)
        if self.fails:
            raise self.error
        return [tile if camera is not None else None for tile, camera in enumerate(cameras)]


class Crowd:
    """Viewers at a table, whose jobs are done by turns."""

    def __init__(self) -> None:
        self.renderer, self.tasks = SlowRenderer(), Tasks()
        self.table = Table(cast(Renderer, self.renderer))
        self.seen: dict[int, Any] = {}
        self._requests = 0

    def want(self, *viewers: int) -> list[Turn]:
        return [self._start(partial(self._render, viewer)) for viewer in viewers]

    def end(self) -> None:
        self.renderer.over = True
        while self.tasks.poll_seconds is not None:
            if (request := self.tasks.ready()) is not None:
                self.tasks.resume(request)

    def _start(self, work: Callable[[], None]) -> Turn:
        self._requests += 1
        return self.tasks.start(self._requests, work)

    def _render(self, viewer: int) -> None:
        try:
            self.seen[viewer] = self.table.render(viewer, CAMERA)
        except (RuntimeError, LostFrameError) as error:
            self.seen[viewer] = error


@pytest.fixture
def crowd() -> Iterator[Crowd]:
    crowd = Crowd()
    DEVICE_SHARING.begin(crowd.tasks)
    yield crowd
    DEVICE_SHARING.begin(None)


def test_who_comes_while_a_frame_is_under_way_is_in_the_next_one(crowd: Crowd) -> None:
    crowd.renderer.over = False
    assert crowd.want(7, 8, 9) == [Turn.OPEN] * TILES
    assert crowd.renderer.frames == [[0]]
    crowd.end()
    assert crowd.renderer.frames == [[0], [0, 1, 2]]  # the first looks on
    assert crowd.seen == {7: 0, 8: 1, 9: 2}
    assert 8 in crowd.table.tiles
    assert crowd.table.tiles.free == 0


def test_who_is_alone_waits_for_nobody(crowd: Crowd) -> None:
    assert crowd.want(7) == [Turn.ENDED]
    crowd.want(8)
    crowd.table.tiles.leave(7)
    assert crowd.want(9, 8) == [Turn.ENDED] * 2
    assert crowd.seen == {7: 0, 8: 1, 9: 0}  # the tile that became free


def test_a_viewer_who_is_not_asked_for_gives_its_tile_back_after_some_frames(crowd: Crowd) -> None:
    crowd.want(7)
    for _ in range(MOST_ABSENT):
        crowd.want(8)
    assert crowd.renderer.frames[-1] == [0, 1]
    crowd.want(7)
    for _ in range(MOST_ABSENT + 1):
        crowd.want(8)
    assert crowd.renderer.frames[-2:] == [[0, 1], [1]]
    assert 7 not in crowd.table.tiles


def test_an_error_is_its_frame_s_and_others_are_to_ask_elsewhere(crowd: Crowd) -> None:
    crowd.renderer.over, crowd.renderer.fails = False, True
    crowd.want(7, 8, 9)
    crowd.end()
    assert crowd.seen[7] is crowd.renderer.error
    assert [type(crowd.seen[viewer]) for viewer in (8, 9)] == [LostFrameError] * 2
    assert crowd.renderer.frames == [[0]]
    assert crowd.table.broken


def test_who_wants_no_picture_any_more_takes_nothing_from_others(crowd: Crowd) -> None:
    crowd.renderer.over = False
    crowd.want(7, 8, 9)
    crowd.tasks.cancel(2)
    with pytest.raises(CancelledError):
        crowd.tasks.resume(2)
    crowd.end()
    assert crowd.seen == {7: 0, 9: 1}
    assert not crowd.table.broken


def test_who_finds_no_tile_left_is_to_ask_elsewhere(crowd: Crowd) -> None:
    crowd.want(6, 7, 8, 9)
    assert crowd.seen == {6: 0, 7: 1, 8: 2, 9: crowd.seen[9]}
    assert isinstance(crowd.seen[9], LostFrameError)


def test_small_pictures_have_many_tiles_and_large_ones_a_frame_each() -> None:
    assert tiles_of((320, 180)) == tiles_of((8, 8)) == MOST_TILES
    assert tiles_of((480, 270)) * 480 * 270 <= FRAME_PIXELS < (tiles_of((480, 270)) + 1) * 480 * 270
    assert tiles_of((1280, 720)) == tiles_of((4096, 4096)) == 1
