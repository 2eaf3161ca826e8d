from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gradient_worker import SLOW_SEED
from harness import Running, wait_for

from server.wire.worker import STILLS, Render

HALL = "/api/v1/scenes/rooms/hall.glb"


def test_a_service_gives_no_scene_out_unless_told(running: Running) -> None:
    answer = running.http.get(f"{HALL}/export.glb")
    assert (answer.status_code, answer.json()["code"]) == (403, "forbidden")
    assert "--exports" in answer.json()["message"]


def test_an_export_does_not_wait_for_ever(serve: Callable[..., Running]) -> None:
    service = serve(exports=True, max_wait_seconds=0.05)
    (engine,) = service.service.engines.engines
    with ThreadPoolExecutor(1) as pool:
        slow = pool.submit(service.http.post, "/api/v1/render", json={"size": [8, 8], "settings": {"seed": SLOW_SEED}})
        wait_for(lambda: any(isinstance(it.job, Render) and it.entry.client == STILLS for it in engine._jobs.running))
        answer = service.http.get("/api/v1/scenes/cornell-box/export.glb")
        assert (answer.status_code, answer.json()["message"]) == (503, "no turn within 0.05 s; try again later")
        assert slow.result().status_code == 200


def test_a_scene_is_downloaded_with_its_edits(serve: Callable[..., Running], tmp_path: Path) -> None:
    (tmp_path / "a hall.glb").write_bytes(b"")
    service = serve(scenes_dir=tmp_path, exports=True)
    place = "/api/v1/scenes/a%20hall.glb"
    assert service.http.patch(place, json={"lights": {"lamp": {"intensity": 0.5}}}).status_code == 200
    answer = service.http.get(f"{place}/export.glb")
    assert (answer.status_code, answer.content) == (200, b"glTF with lamp")
    assert answer.headers["Content-Type"] == "model/gltf-binary"
    assert answer.headers["Content-Disposition"] == "attachment; filename*=UTF-8''a%20hall.glb"
    materials = {f"material {number}": {"color": [0.1, 0.2, 0.3]} for number in range(900)}  # too long for an address
    own = service.http.post(f"{place}/export.glb", json={"lights": {"sky": {"on": False}}, "materials": materials})
    assert own.content == b"glTF with sky"
    wrong = service.http.post(f"{place}/export.glb", json={"lights": {"sky": {"on": 5}}})
    assert wrong.status_code == 422
    assert service.http.get("/api/v1/scenes/nowhere.glb/export.glb").status_code == 404
    with service.service.exporting.taken("127.0.0.1"):
        assert service.http.get(f"{place}/export.glb").status_code == 429
