from gpu.core.device import choose_device
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from server.wire.worker import SceneRef
from server.worker.loaded_scene import build
from tests.bench.edits import WARM_UP, edits_of, measure, with_bulb


def test_every_kind_of_edit_is_timed_and_most_go_on_in_their_arrays(cpu: str) -> None:
    settings = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)
    base = build(SceneRef("box", "cornell-box"), with_bulb(load_scene("cornell-box")), choose_device(cpu))
    kinds = edits_of(base.scene)
    assert {"dim", "recolour", "move light", "material"} <= kinds.keys()
    for kind, edit_of in kinds.items():
        found = measure(base, edit_of, settings, size=(32, 18), rounds=1)
        stays = kind != "move object"
        parts = ("first", "edit", "frame", "moving", "walking", *(("trace", "cluster") if stays else ()))
        assert min(found[part] for part in parts) > 0.0
        assert found["anew"] == (1 if stays else WARM_UP + 1)
