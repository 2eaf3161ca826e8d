"""What is in scenes, and what is not, before jobs of them wait."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gpu.errors import UserError
from gpu.scene.edits import ObjectEdit, SceneEdits
from server.rest.scene_parts import check_info, check_parts, info_of
from server.scenes.scene_info import MOST_PARTS
from server.settings import ServerSettings
from server.wire.browser import AnimationInfo, Bounds, ObjectInfo, SceneInfo
from server.wire.worker import LookAt, SceneCamera, SceneRef

BOX = Bounds(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0))
HALL = SceneRef("hall.glb", "/scenes/hall.glb")
INFO = SceneInfo(
    id="hall.glb",
    name="hall",
    cameras=(),
    bounds=BOX,
    objects=(ObjectInfo(id="chair", box=BOX), ObjectInfo(id="table", box=BOX)),
    animations=(AnimationInfo(id="walk", seconds=2.0),),
    triangles=1,
)
LOOKING = LookAt((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), None, 90.0)
SOFA = SceneEdits(objects={"sofa": ObjectEdit(visible=False)})


def reading(asked: list[SceneRef], environment: Path | None = None) -> Any:
    """A service that notes which scenes it reads, with that environment around all of them."""

    async def inspect(scene: SceneRef) -> SimpleNamespace:
        asked.append(scene)
        return SimpleNamespace(info=INFO)

    settings = ServerSettings(environment=environment)
    return SimpleNamespace(residency=SimpleNamespace(inspect=inspect), settings=settings)


def test_files_are_read_and_built_in_scenes_made() -> None:
    asked: list[SceneRef] = []
    assert asyncio.run(info_of(reading(asked), HALL)) is INFO
    box = asyncio.run(info_of(reading(asked), SceneRef("cornell-box", "cornell-box")))
    assert box.id == "cornell-box"
    assert box.animations == ()
    assert box.objects
    assert asked == [HALL]


def test_built_in_scenes_have_the_sky_that_is_around_them() -> None:
    box = SceneRef("cornell-box", "cornell-box")
    for environment, added in ((Path("noon.hdr"), False), (None, True)):
        info = asyncio.run(info_of(reading([], environment), box))
        assert {light.id: light.added for light in info.lights} == {"light": False, "sun": True, "sky": added}


def test_nothing_is_read_for_what_every_scene_has() -> None:
    asked: list[SceneRef] = []
    for view in (SceneCamera(0), LOOKING):
        asyncio.run(check_parts(reading(asked), HALL, view, None))
    assert asked == []
    for wanted in ((SceneCamera("attic"), None), (LOOKING, SOFA)):
        with pytest.raises(UserError):
            asyncio.run(check_parts(reading(asked), HALL, *wanted))
    assert asked == [HALL, HALL]


def test_of_more_parts_than_are_listed_nothing_is_known() -> None:
    with pytest.raises(UserError, match=r"objects\.sofa: the scene has no such object; it has chair, table"):
        check_info(INFO, LOOKING, SOFA)
    check_info(INFO.model_copy(update={"objects": INFO.objects * (MOST_PARTS // 2)}), LOOKING, SOFA)
