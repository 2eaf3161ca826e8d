from collections.abc import Callable

import pytest
import warp as wp

import server.worker.renderer_pool
from gpu.device_scene.upload import DeviceScene
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from server.wire.worker import SceneRef
from server.worker.renderer_pool import BYTES_A_CLUSTER, BYTES_A_PAIR, BYTES_A_PIXEL, Renderers

BOX, TWIN = SceneRef("box", "cornell-box"), SceneRef("twin", "cornell-box")
SETTINGS = RenderSettings(sp_clusters=4, vpls=64, vpl_clusters=4)
Get = Callable[..., object]


@pytest.fixture(scope="module")
def resident(cpu: str) -> DeviceScene:
    return DeviceScene(load_scene("cornell-box"), cpu)


def silent(_: str, __: float) -> None:
    pass


def test_a_renderer_is_kept_for_its_scene_size_and_settings(resident: DeviceScene) -> None:
    kept = Renderers(wp.get_device("cpu"))
    first = kept.get(BOX, resident, (8, 8), SETTINGS, silent)
    assert kept.get(BOX, resident, (8, 8), SETTINGS, silent) is first
    assert kept.get(BOX, resident, (8, 8), SETTINGS.model_copy(update={"frames": 9}), silent) is first
    assert kept.get(BOX, resident, (8, 9), SETTINGS, silent) is not first
    assert kept.get(TWIN, resident, (8, 8), SETTINGS, silent) is not first
    assert kept.get(BOX, resident, (8, 8), SETTINGS.model_copy(update={"seed": 1}), silent) is not first
    kept.drop(BOX)
    assert len(kept) == 1
    kept.clear()
    assert len(kept) == 0


def test_the_one_used_longest_ago_makes_room(resident: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    clusters = 4 * BYTES_A_CLUSTER + 4 * 4 * BYTES_A_PAIR
    monkeypatch.setattr(server.worker.renderer_pool, "CPU_BYTES", 200 * BYTES_A_PIXEL + 3 * clusters)
    kept = Renderers(wp.get_device("cpu"))
    first = kept.get(BOX, resident, (10, 10), SETTINGS, silent)
    kept.get(BOX, resident, (9, 10), SETTINGS, silent)
    assert kept.get(BOX, resident, (10, 10), SETTINGS, silent) is first
    kept.get(BOX, resident, (5, 10), SETTINGS, silent)
    assert len(kept) == 2
    assert kept.get(BOX, resident, (10, 10), SETTINGS, silent) is first
    kept.get(BOX, resident, (30, 30), SETTINGS, silent)  # larger than all that may be kept: alone
    assert len(kept) == 1


@pytest.mark.parametrize(("clusters", "pairs"), [(3, 2), (2, 3)])
def test_clusters_and_pairs_of_them_take_room_too(
    resident: DeviceScene, monkeypatch: pytest.MonkeyPatch, clusters: int, pairs: int
) -> None:
    room = 3 * 64 * BYTES_A_PIXEL + clusters * 50 * BYTES_A_CLUSTER + pairs * 1000 * BYTES_A_PAIR
    monkeypatch.setattr(server.worker.renderer_pool, "CPU_BYTES", room)
    kept = Renderers(wp.get_device("cpu"))
    many = SETTINGS.model_copy(update={"sp_clusters": 50, "vpl_clusters": 20})
    for seed in range(3):
        kept.get(BOX, resident, (8, 8), many.model_copy(update={"seed": seed}), silent)
    assert len(kept) == 2
