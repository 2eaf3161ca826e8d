from pathlib import Path

from gltf_motion import SECONDS, moving

from gpu.core.device import choose_device
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from server.wire.worker import SceneRef
from server.worker.loaded_scene import build
from tests.bench.edits import ROUNDS, WARM_UP, edits_of, measure, with_bulb


def test_every_kind_of_edit_is_timed_and_goes_on_in_its_arrays(cpu: str) -> None:
    settings = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)
    base = build(SceneRef("box", "cornell-box"), with_bulb(load_scene("cornell-box")), choose_device(cpu))
    kinds = edits_of(base.scene)
    assert {"dim", "recolour", "move light", "material"} <= kinds.keys()
    for edit_of in kinds.values():
        found = measure(base, edit_of, settings, size=(32, 18), rounds=1)
        parts = ("first", "edit", "frame", "moving", "walking", "trace", "cluster")
        assert min(found[part] for part in parts) > 0.0
        assert found["anew"] == 1


def test_time_is_an_edit_of_a_scene_with_animations(tmp_path: Path) -> None:
    edit_of = edits_of(moving(tmp_path).load())["time"]
    times = [edit_of(number).time for number in range(WARM_UP + ROUNDS)]
    assert times == sorted(set(times))
    assert 0.0 < times[0] < times[-1] < SECONDS
