"""Engines as the settings say."""

import pytest
from harness import GRADIENT_WORKER

from gpu.errors import UserError
from server.engines import make_engines
from server.settings import ServerSettings


def test_a_worker_is_told_what_it_serves_and_its_limits() -> None:
    settings = ServerSettings(scene="cornell-box", max_scenes=3, device="one,two")
    starts = [engine.workers.start for engine in make_engines(settings, GRADIENT_WORKER).engines]
    assert [start.device for start in starts] == ["one", "two"]
    assert (starts[0].scene.id, starts[0].max_scenes) == ("cornell-box", 3)
    assert starts[0].scene_limits == settings.scene_limits


def test_a_scene_that_is_not_there_is_said() -> None:
    with pytest.raises(UserError, match="there is no such file, nor a built-in scene of that name"):
        make_engines(ServerSettings(scene="gone.glb"))
