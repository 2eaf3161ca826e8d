import gc
import re
import weakref
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import warp as wp

import server.worker.renderer_pool
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.features import SceneFeatures
from gpu.errors import OutOfMemoryError
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.scene.edits import LightEdit, SceneEdits
from gpu.scene.load import load_scene
from gpu.settings import Method, RenderSettings
from server.wire.worker import HEARTBEAT, STILLS, SceneRef
from server.worker.loaded_scene import LoadedScene, build, edit
from server.worker.renderer_pool import LANES_A_FRAME, VIEWS_A_VIEWER, RendererPool

BOX, TWIN = SceneRef("box", "cornell-box"), SceneRef("twin", "cornell-box")
NOTHING = SceneFeatures(**dict.fromkeys(SceneFeatures.__dataclass_fields__, False))
SETTINGS = RenderSettings(sp_clusters=4, vpls=64, vpl_clusters=4)
SEEDS = [SETTINGS.model_copy(update={"seed": seed}) for seed in range(4)]


class Pool(RendererPool):
    """Of the Cornell box on the CPU; with room for `room` bytes, where a renderer takes 100 and a view of it 10."""

    def __init__(self, scene: LoadedScene, room: int = 100_000, frames: int = 1) -> None:
        super().__init__(wp.get_device("cpu"), frames)
        self._scene, self._most_bytes = scene, room

    def take(
        self,
        viewer: int = 1,
        size: tuple[int, int] = (8, 8),
        settings: RenderSettings = SETTINGS,
        scene: SceneRef = BOX,
    ) -> tuple[Renderer, ViewState]:
        here = replace(self._scene, ref=scene)
        return self.get(viewer, self.lane_of(viewer), here, size, settings, lambda what, fraction: None)

    def _bytes_of(self, key: object, views: int) -> int:
        return 100 + 10 * views


@pytest.fixture(scope="module")
def scene(cpu: str) -> LoadedScene:
    return build(BOX, load_scene("cornell-box"), wp.get_device(cpu))


def test_a_renderer_is_kept_for_its_scene_size_and_settings(scene: LoadedScene) -> None:
    pool = Pool(scene)
    first, _ = pool.take()
    assert pool.take()[0] is first
    assert pool.take(viewer=2)[0] is first
    assert pool.take(settings=SETTINGS.model_copy(update={"frames": 9}))[0] is first
    assert pool.take(size=(8, 9))[0] is not first
    assert pool.take(scene=TWIN)[0] is not first
    assert pool.take(settings=SEEDS[1])[0] is not first
    pool.drop(BOX)
    assert len(pool) == 1
    pool.clear()
    assert len(pool) == 0


def test_each_viewer_of_a_renderer_has_a_view_of_its_own(scene: LoadedScene) -> None:
    pool = Pool(scene)
    first, second = pool.take(1)[1], pool.take(2)[1]
    assert first is not second
    assert pool.take(1)[1] is first
    assert pool.take(2)[1] is second


def test_a_viewer_that_leaves_has_its_views_freed_and_nobody_else_s(scene: LoadedScene) -> None:
    pool = Pool(scene)
    walking, resting, other = (weakref.ref(pool.take(*of)[1]) for of in ((1, (8, 8)), (1, (16, 16)), (2, (8, 8))))
    pool.leave(1)
    pool.leave(3)  # never came
    gc.collect()
    assert (walking(), resting()) == (None, None)
    assert other() is pool.take(2)[1]
    assert len(pool) == 2  # who comes next finds their renderers


@pytest.mark.parametrize("change", [{"scene": TWIN}, {"settings": SEEDS[1]}])
def test_a_view_goes_when_its_viewer_looks_at_something_else(scene: LoadedScene, change: dict[str, object]) -> None:
    pool = Pool(scene)
    before, other = pool.take(1)[1], pool.take(2)[1]
    pool.take(1, **change)  # type: ignore[arg-type]
    assert pool.take(1)[1] is not before
    assert pool.take(2)[1] is other


def test_a_viewer_has_views_of_a_few_sizes(scene: LoadedScene) -> None:
    pool = Pool(scene)
    sizes = [(8, 8 + number) for number in range(VIEWS_A_VIEWER + 1)]
    views = [pool.take(size=size)[1] for size in sizes]
    assert [pool.take(size=size)[1] for size in sizes[1:]] == views[1:]
    assert pool.take(size=sizes[0])[1] is not views[0]


def test_the_renderer_used_longest_ago_makes_room_with_its_views(scene: LoadedScene) -> None:
    pool = Pool(scene, room=2 * 110)
    first = pool.take(1, settings=SEEDS[0])
    pool.take(2, settings=SEEDS[1])
    assert pool.take(1, settings=SEEDS[0]) == first
    pool.take(3, settings=SEEDS[2])
    assert len(pool) == 2
    assert pool.take(1, settings=SEEDS[0]) == first
    assert pool.take(1, settings=SEEDS[0])[1] is first[1]


def test_views_take_room_too(scene: LoadedScene) -> None:
    pool = Pool(scene, room=2 * 100 + 30)
    shared = pool.take(1)[0]
    pool.take(2, settings=SEEDS[1])
    pool.take(3)
    assert len(pool) == 2
    pool.take(4)
    assert len(pool) == 1
    assert pool.take(1)[0] is shared


def test_when_nothing_else_can_go_views_of_the_renderer_do(scene: LoadedScene) -> None:
    pool = Pool(scene, room=120)
    renderer, first = pool.take(1)
    second = pool.take(2)[1]
    assert pool.take(1)[1] is first
    assert pool.take(3)[0] is renderer
    assert pool.take(1)[1] is first
    assert pool.take(2)[1] is not second


def test_one_that_is_larger_than_all_that_may_be_kept_is_alone(scene: LoadedScene) -> None:
    pool = Pool(scene, room=50)
    for seed in SEEDS[:2]:
        pool.take(settings=seed)
        assert len(pool) == 1


def test_no_more_than_so_many_renderers_are_kept(scene: LoadedScene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server.worker.renderer_pool, "MOST", 2)
    pool = Pool(scene)
    for seed in SEEDS:
        pool.take(settings=seed)
    assert len(pool) == 2


def test_memory_is_what_the_method_takes(cpu: str) -> None:
    pool = RendererPool(wp.get_device(cpu))
    key = server.worker.renderer_pool._Key

    def took(
        views: int,
        size: tuple[int, int] = (100, 100),
        method: Method = Method.FUZZY_VPL,
        *,
        has: SceneFeatures = NOTHING,
        **counts: int,
    ) -> int:
        settings = SETTINGS.model_copy(update={"method": method, **counts})
        return pool._bytes_of(key(BOX, size, settings, has), views)

    for views in (1, 2):
        assert took(views, method=Method.PATH) < views * 20 * 10_000  # the pictures' radiance, and little else
    assert took(1, size=(100, 101)) - took(1) == 100 * (FuzzyVpl.pixel_bytes + FuzzyVpl.view_pixel_bytes)
    shared, own = FuzzyVpl.cluster_bytes(sample_counts_of(SETTINGS, wp.get_device(cpu)))
    assert took(2) - took(1) == 10_000 * FuzzyVpl.view_pixel_bytes + own
    assert took(0) == 10_000 * FuzzyVpl.pixel_bytes + shared
    assert took(2, has=replace(NOTHING, soft=True)) - took(2) == 2 * 10_000 * FuzzyVpl.soft_view_pixel_bytes
    assert took(1, has=replace(NOTHING, lamps=True)) - took(1) == 10_000 * FuzzyVpl.lamps_pixel_bytes
    for count in ("sp_clusters", "vpl_clusters"):
        assert took(1, **{count: 500}) > took(1)


def test_what_there_is_no_memory_for_is_refused_with_what_would_do(
    scene: LoadedScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = [6_000_000_000]
    monkeypatch.setattr("server.worker.renderer_pool.free_bytes", lambda device: free[0])
    pool = RendererPool(wp.get_device("cpu"))
    with pytest.raises(OutOfMemoryError, match=r"^7680×4320 pixels .* about 2\d\.\d GB .* 6\.0 GB are free") as refused:
        pool.get(1, 0, scene, (7680, 4320), RenderSettings(), lambda what, fraction: None)
    width, height = (int(side) for side in re.findall(r"at most (\d+)×(\d+), or for fewer", str(refused.value))[0])
    assert len(pool) == 0
    pool._check_memory(server.worker.renderer_pool._Key(BOX, (width, height), SETTINGS, NOTHING), width * height * 646)
    free[0] = 0
    pool.get(1, 0, scene, (8, 8), SETTINGS, lambda what, fraction: None)  # small ones are tried in any case


def test_each_state_of_a_scene_has_renderers_of_its_own(scene: LoadedScene) -> None:
    pool, off = Pool(scene), SceneEdits(lights={"light": LightEdit(on=False)})
    first, _ = pool.take()
    pool._scene = edit(scene, off)
    second, view = pool.take()
    assert second is not first
    assert pool.take() == (second, view)
    pool.drop_state(pool._scene)
    assert len(pool) == 1
    assert pool.take()[0] is not second
    pool.drop(BOX)
    assert len(pool) == 0


def test_viewers_are_spread_over_lanes_and_those_of_one_share_its_renderers(scene: LoadedScene) -> None:
    pool = Pool(scene, frames=2)
    lanes = LANES_A_FRAME * 2
    viewers = range(1, lanes + 2)
    assert [pool.lane_of(viewer) for viewer in viewers] == [*range(lanes), 0]
    assert pool.lane_of(STILLS) == pool.lane_of(HEARTBEAT) == 0
    first = pool.take(1)[0]
    assert [pool.take(viewer)[0] is first for viewer in (2, lanes + 1, STILLS)] == [False, True, True]
    assert len(pool) == 2
    pool.leave(2)
    assert (pool.lane_of(lanes + 2), pool.lane_of(3)) == (1, 2)  # the place that became free


def test_renderers_of_all_lanes_together_have_so_much_memory(
    scene: LoadedScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    pool = Pool(scene, room=2 * 110, frames=2)
    for viewer in (1, 2, 3):
        pool.take(viewer)
    assert len(pool) == 2
    monkeypatch.setattr(server.worker.renderer_pool, "MOST", 1)
    pool._most_bytes = 100_000
    for viewer in (1, 2, 3):
        pool.take(viewer)
        pool.take(viewer, size=(16, 16))
    assert len(pool) == LANES_A_FRAME * 2


def test_as_many_frames_as_the_device_has_lanes(cpu: str) -> None:
    pool = RendererPool(wp.get_device(cpu))
    assert pool.frames == 1
    assert {pool.lane_of(viewer) for viewer in range(9)} == {0}


def test_what_is_there_already_is_not_weighed_again(scene: LoadedScene, monkeypatch: pytest.MonkeyPatch) -> None:
    pool = Pool(scene)
    kept = pool.take()
    monkeypatch.setattr(pool, "_bytes_of", None)
    assert pool.take() == kept


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
def test_others_have_the_device_while_arrays_of_many_pixels_are_found(
    scene: LoadedScene, monkeypatch: pytest.MonkeyPatch, method: Method
) -> None:
    size, most = (320, 240), 120  # bytes a pixel: a GPU's driver finds 4 GB in some 60 ms
    settings = SETTINGS.model_copy(update={"method": method})
    pool, found, pieces = Pool(scene), wp.zeros, [0]
    pool.take(settings=settings)  # what it shares with others is there

    class Others:
        def due(self, *, idle: bool = False) -> bool:
            return not idle

        def give(self) -> None:
            pieces.append(0)

        def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
            assert over()

    def counted(*args: Any, **kwargs: Any) -> wp.array:
        array = found(*args, **kwargs)
        pieces[-1] += array.capacity
        return array

    monkeypatch.setattr(wp, "zeros", counted)
    DEVICE_SHARING.begin(Others())
    try:
        pool.take(size=size, settings=settings)
    finally:
        DEVICE_SHARING.begin(None)
    assert sum(pieces) > 3 * most * size[0] * size[1]
    assert max(pieces) < most * size[0] * size[1]
