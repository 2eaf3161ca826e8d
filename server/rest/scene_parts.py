"""Whether a scene has what a job names, so that it is refused when it is asked for, not when its turn comes."""

import asyncio

from gpu.scene.builtin import BUILTIN
from gpu.scene.edits import SceneEdits, check
from server.scenes.scene_edits import editable
from server.scenes.scene_info import MOST_PARTS, describe_scene
from server.scenes.view_camera import check_view
from server.service import Service
from server.wire.browser import SceneInfo
from server.wire.worker import CameraSpec, SceneCamera, SceneRef


async def info_of(service: Service, scene: SceneRef) -> SceneInfo:
    """What is in a scene; its file is read for that, as it will be for its pictures, if nobody has asked for it yet."""
    if scene.source in BUILTIN:
        made, around = await asyncio.to_thread(BUILTIN[scene.source]), service.settings.environment is not None
        return describe_scene(scene.id, made, in_environment=around)
    return (await service.residency.inspect(scene)).info


async def check_parts(service: Service, scene: SceneRef, view: CameraSpec, edits: SceneEdits | None) -> None:
    """As `check_info`; nothing is read where a scene's first camera shows it without edits of a client's own."""
    if edits is not None or (isinstance(view, SceneCamera) and view.camera != 0):
        check_info(await info_of(service, scene), view, edits)


def check_info(info: SceneInfo, view: CameraSpec, edits: SceneEdits | None) -> None:
    """UserError for a camera, or for parts named by edits, that a scene has not; of parts that are not listed, since
    they are too many, nothing is known.
    """
    check_view(info, view)
    if edits is not None and max(len(info.lights), len(info.materials), len(info.objects)) < MOST_PARTS:
        check(edits, editable(info))
