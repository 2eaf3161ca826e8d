"""POST /assign: which of several replicas a viewer goes to."""

from fastapi import APIRouter
from pydantic import BaseModel, Field

from server.errors import WITH_BODY, refusals
from server.refusals import ForbiddenError
from server.service import TheService
from server.wire.browser import Message, SceneId

router = APIRouter(prefix="/api/v1", responses=refusals(404, *WITH_BODY))


class AssignRequest(Message):
    """What a viewer wants to see."""

    scene: SceneId = Field(description="scene id, as the replicas list it")


class Assigned(BaseModel):
    """Where to go."""

    url: str = Field(description="of a replica's page, as a path on the site of the proxy in front, such as /r/0/")


@router.post("/assign", operation_id="assign")
async def assign(wanted: AssignRequest, service: TheService) -> Assigned:
    """The replica of `--replicas` that has the scene on its device, or else has the fewest viewers; 403 where none are
    named, 503 where none can render.
    """
    if service.replicas is None:
        raise ForbiddenError("this server knows no replicas; whoever runs it can name them with --replicas")
    return Assigned(url=f"{await service.replicas.choose(wanted.scene)}/")
