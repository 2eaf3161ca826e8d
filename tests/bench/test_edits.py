from gpu.device_scene.upload import DeviceScene
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from tests.bench.edits import measure


def test_every_part_of_an_edit_is_timed(cpu: str) -> None:
    settings = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)
    found = measure(DeviceScene(load_scene("cornell-box"), cpu), settings, size=(32, 18), rounds=1)
    assert found.keys() == {"state", "table", "renderer", "frame", "walking", "edit"}
    assert min(found.values()) > 0.0
    assert found["edit"] == sum(found[part] for part in ("state", "table", "renderer", "frame"))
