import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gpu.scene.camera import look_at
from gpu.settings import RenderSettings
from tests.bench import elsewhere


def test_views_are_turned_tilted_and_moved_from_the_scenes_own() -> None:
    own = look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    seen = {name: camera.to_world for name, camera in elsewhere.views(own, 10.0)}
    assert np.allclose(seen["own"], own.to_world)
    assert seen["back"][:3, 2] @ own.to_world[:3, 2] < -0.9  # looks the other way
    assert seen["back"][1, 2] < 0.0 < seen["right"][1, 2]  # up, and down
    assert np.allclose(seen["near"][:3, 3], (0.0, 0.0, -0.6))


def test_rooms_are_looked_at_from_their_own_cameras() -> None:
    scene = elsewhere.scene_of("steel-room")
    assert [name for name, _ in elsewhere.views_of("steel-room", scene)] == ["room"]
    assert [name for name, _ in elsewhere.views_of("cornell-box", scene)] == list(elsewhere.VIEWS)


def test_a_blotch_counts_and_a_speck_that_a_blur_hides_is_counted_apart() -> None:
    reference, picture = np.ones((60, 90, 3)), np.ones((60, 90, 3), np.float32)
    picture[10, 10] = 9.0
    picture[20, 20:22] = 0.1
    darker, brighter = elsewhere.blotches(picture, reference)
    assert -0.3 < darker < 0.0 < brighter < 0.7
    assert elsewhere.specks(picture, reference) == (2, 1)
    picture[30:50, 50:70] = 1.5
    assert 0.45 < elsewhere.blotches(picture, reference)[1] < 0.7


def test_each_view_has_errors_noise_and_pictures_unless_it_is_black(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    few = {"SIZE": (24, 16), "WALKED": 2, "RESTING": 2, "PATH_FRAMES": 2}
    for name, value in {**few, "VIEWS": {name: elsewhere.VIEWS[name] for name in ("own", "back")}}.items():
        monkeypatch.setattr(elsewhere, name, value)
    elsewhere.main("cpu", tmp_path, ("cornell-box",), RenderSettings(sp_clusters=8, vpls=64, vpl_clusters=8))
    own, back = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert back == {"scene": "cornell-box", "view": "back", "black": True}
    assert 0.0 < own["noise"] < 1.0
    for name in ("walk", "single", "rest"):
        assert own[name]["nonfinite"] == 0
        assert 0.3 < own[name]["energy"] < 3.0
        with Image.open(tmp_path / f"cornell-box-own-{name}.png") as picture:
            assert picture.size == (24, 16)
