from collections.abc import Callable
from pathlib import Path

from harness import Running

HALL = "/api/v1/scenes/rooms/hall.glb"


def test_a_service_gives_no_scene_out_unless_told(running: Running) -> None:
    answer = running.http.get(f"{HALL}/export.glb")
    assert (answer.status_code, answer.json()["code"]) == (403, "forbidden")
    assert "--exports" in answer.json()["message"]


def test_a_scene_is_downloaded_with_its_edits(serve: Callable[..., Running], tmp_path: Path) -> None:
    (tmp_path / "a hall.glb").write_bytes(b"")
    service = serve(scenes_dir=tmp_path, exports=True)
    place = "/api/v1/scenes/a%20hall.glb"
    assert service.http.patch(place, json={"lights": {"lamp": {"intensity": 0.5}}}).status_code == 200
    answer = service.http.get(f"{place}/export.glb")
    assert (answer.status_code, answer.content) == (200, b"glTF with lamp")
    assert answer.headers["Content-Type"] == "model/gltf-binary"
    assert answer.headers["Content-Disposition"] == "attachment; filename*=UTF-8''a%20hall.glb"
    own = service.http.get(f"{place}/export.glb", params={"edits": '{"lights": {"sky": {"on": false}}}'})
    assert own.content == b"glTF with sky"
    for wrong in ("{", '{"lights": {"sky": {"on": 5}}}'):
        assert service.http.get(f"{place}/export.glb", params={"edits": wrong}).status_code == 422
    assert service.http.get("/api/v1/scenes/nowhere.glb/export.glb").status_code == 404
    with service.service.exporting.taken("127.0.0.1"):
        assert service.http.get(f"{place}/export.glb").status_code == 429
