"""POST /pick: what is at a pixel of a view."""

from typing import Annotated

from fastapi import APIRouter
from pydantic import Field

from gpu.errors import UserError
from gpu.scene.edits import SceneEdits
from gpu.scene.import_options import ImportOptions
from server.errors import WITH_BODY, refusals
from server.places import asker
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.service import TheService
from server.wire.browser import MAX_SIDE, Message, PickedPart, SceneId, Size
from server.wire.cameras import CameraChoice, view_of
from server.wire.worker import STILLS, Pick, Picked

router = APIRouter(prefix="/api/v1", responses=refusals(404, 507, *WITH_BODY))


Place = Annotated[float, Field(ge=0.0, le=MAX_SIDE)]


class PickRequest(Message):
    """A point of a picture; what is left out gets its default, as of a still."""

    scene: SceneId | None = Field(default=None, description="scene id; the served scene when not given")
    scene_options: ImportOptions | None = Field(
        default=None, description="how its file is read; as the service does when not given"
    )
    camera: CameraChoice = Field(default=0, description="one of the scene's by index or name, or one of your own")
    edits: SceneEdits | None = Field(
        default=None, description="all that differs from its file; as all who look see it when not given"
    )
    size: Size = Field(default=(1280, 720), description="width and height of the picture [px]")
    pixel: tuple[Place, Place] = Field(description="from the picture's top left [px]; pixels' centres are at halves")

    @property
    def place(self) -> tuple[float, float]:
        """As shares of the picture's sides; UserError where it is beside the picture."""
        x, y = (at / side for at, side in zip(self.pixel, self.size, strict=True))
        if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
            raise UserError(f"pixel: must be in the picture, from 0, 0 to {self.size[0]}, {self.size[1]}")
        return x, y


@router.post("/pick", operation_id="pick")
async def pick(wanted: PickRequest, service: TheService) -> PickedPart:
    """What a camera sees at a pixel of its picture: object, material, light, and where; as the scene is edited.

    The scene is loaded for that.
    """
    place = wanted.place
    service.check_picks(asker.get())
    ref = await service.catalogue.look_up(wanted.scene, wanted.scene_options)
    if not service.engines.ready:
        raise WorkerLostError(f"the renderer is not ready: {service.engines.activity.text}")
    await service.residency.open(ref)
    job = Pick(ref, view_of(wanted.camera), wanted.size, place, await service.edits_of(ref, wanted.edits))
    answer, _ = await service.engines.ask(STILLS, job, Urgency.STILL, service.settings.max_wait_seconds)
    assert isinstance(answer, Picked)
    return answer.part
