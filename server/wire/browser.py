"""The walkthrough's wire protocol, version 2: `GET /api/v1/stream` upgraded to a WebSocket, no compression.

Text messages are JSON objects with a `type`; unknown types and unknown fields are refused. Binary messages go from the
server to the viewer only: one frame each. All matrices are 16 numbers, column after column (glTF's order), camera to
world; cameras look along −Z with +Y up; the world is in metres with +Y up, and `scene.frame` says how the file's own
coordinates become those; angles are radians.

A session
    viewer  hello {protocol, size, scene?, scene_options?, settings?, stream?, codecs?}
    server  welcome {protocol, viewer, scenes, settings_schema, codecs, limits, still_frames, takes_edits,
                gives_exports}                                                   at once
            status {state, text, fraction}                   while the scene is read and built
            scene {id, name, cameras, bounds, ...}           when it is known; again after each change
    viewer  pose {id, matrix, yfov, near}
                as often as it likes; only the newest counts. There is no frame before the first pose.
    server  <frame>
                for the newest pose: small ones while the pose changes, one of the wanted size when it rests, then ever
                sharper ones of that view until one is final; then nothing, until something changes.
    viewer  ack {frame, age_ms?, decode_ms?, broken?}
                for each frame that it has shown or thrown away; it covers all older ones too. Only a few frames are
                unacknowledged, at first `limits.window`, more on a long way: then the server waits. A viewer that
                acknowledges nothing for long is closed. age_ms: from the sending of the frame's pose until the
                picture was shown, for the first frame of a pose; decode_ms: what decoding took of that.
    viewer  edit {id, patch}
                lights, materials and objects of the scene change, for all who look at it or for this viewer alone;
                `patch` is a JSON Merge Patch (RFC 7396) of the edits.
    viewer  own {id, own, share?}
                its edits are its own from now on, until it changes scene or leaves: they begin as those of all, who do
                not see them, nor it what all change; or they are those of all again, which with `share` become what
                its own were.
    server  edits {scene, edits, edit, own, suns, shared_over?}
                after each scene, and when somebody has edited it: all that differs from its file; `edit` is the newest
                id of this viewer's `edit` and `own` that was dealt with, also if it was refused; `suns` says where
                lights shine that are the sun of a date; `shared_over` is what all saw before this viewer shared its
                own. The next frame shows it.
    viewer  settings {id, scene?, scene_options?, size?, settings?, stream?}
                what is left out stays as it is; `settings`, `stream` and `scene_options` are replaced as a whole (what
                they leave out gets its default). The newest pose is rendered again. After a change of scene, or of how
                its file is read, the server waits for a new pose.
    server  error {code, message}
                a message was refused or a render failed; the session goes on without what was asked for. The codes
                are `ErrorCode`. After a failed render the next one comes with the next settings message.

`status.state` is "loading" (text and fraction say what), "ready" (a frame comes when a pose does), "recovering" (the
renderer died and is started again: the socket stays, the newest pose is rendered as soon as it is back) or "stopping"
(the service ends: the socket is about to be closed with 1012). Pose ids and settings ids are the viewer's, from 1,
increasing; frame ids are the server's, from 1, increasing, and frames are sent in that order. A frame names the newest
pose and the newest settings that it was rendered with.

The server closes with 1002 (no valid hello first), 1008 (refused by policy), 1009 (message too big), 1011 (a fault of
the server, or no answer to its pings), 1012 (server stops) or 1013 (too many viewers, or a viewer that acknowledged
nothing for long: try again later). The page reconnects with backoff after all but 1002, 1008 and 1009.

A viewer that can set no headers may offer two subprotocols: "lumenwalk", which is taken, and "bearer." with its token
in base64url without padding.

server.wire.frame_header has the layout of a frame.
"""

from enum import StrEnum
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, TypeAdapter, ValidationError, field_validator

from gpu.errors import UserError
from gpu.scene.animation.moment import AnimationId, Moment
from gpu.scene.edits import Color, LightEdit, MaterialEdit, ObjectEdit, PartId, SceneEdits
from gpu.scene.import_options import DEFAULT_OPTIONS, Axis, ImportOptions
from gpu.scene.parts import LightForm
from gpu.settings import Quality, RenderSettings
from server.refusals import reason

PROTOCOL = 2
SUBPROTOCOL = "lumenwalk"
WINDOW = 2

MAX_SIDE = 16_384
Side = Annotated[int, Field(ge=1, le=MAX_SIDE)]
Size = tuple[Side, Side]
Id = Annotated[int, Field(ge=1, le=2**32 - 1)]
MAX_SCENE_ID = 512  # characters
SceneId = Annotated[str, Field(min_length=1, max_length=MAX_SCENE_ID)]
Matrix = Annotated[tuple[FiniteFloat, ...], Field(min_length=16, max_length=16)]
RIGID_TOLERANCE = 1e-3
MAX_DISTANCE = 1e15  # of a camera from the origin: the squares of distances must be numbers of single precision
MOST_PATCHED = 1000  # lights, or materials, that one patch may name


class Message(BaseModel):
    """Base of all control messages."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


# --- viewer to server ------------------------------------------------------------------------------------------------


CodecName = Literal["jpeg", "png", "h264"]


class Stream(Message):
    """How a viewer wants its frames sent."""

    motion_scale: float | None = Field(
        None, ge=0.125, le=1.0, description="side of frames while moving, as a share of `size`; None: by speed"
    )
    lossless: bool = Field(False, description="the final frame of a still view is lossless, if the viewer takes png")
    video: bool | None = Field(
        None, description="frames while moving are H.264, if the viewer and the server take it; None: on slow lines"
    )


class Hello(Message):
    """The first message of a viewer."""

    type: Literal["hello"]
    protocol: Literal[2]
    size: Size = Field(description="of frames that do not move, width and height [px]")
    scene: SceneId | None = Field(None, description="scene id; None is the served scene")
    scene_options: ImportOptions | None = Field(None, description="how its file is read; None is as the server does")
    settings: RenderSettings = RenderSettings()
    stream: Stream = Stream()
    codecs: tuple[str, ...] = Field(("jpeg",), max_length=16, description="that the viewer decodes, the best first")


class Pose(Message):
    """Where the viewer stands now."""

    type: Literal["pose"]
    id: Id
    matrix: Matrix = Field(description="camera to world, column-major, rotation and translation only")
    yfov: float = Field(gt=0.01, lt=3.1, description="vertical field of view [rad]")
    near: float = Field(0.0, ge=0.0, lt=1e30, description="what is less far in front of the camera is cut away [m]")

    @field_validator("matrix")
    @classmethod
    def _rigid(cls, matrix: tuple[float, ...]) -> tuple[float, ...]:
        check_rigid(matrix)
        return matrix


class Settings(Message):
    """A change of scene, frame size or render settings; what is None stays."""

    type: Literal["settings"]
    id: Id
    scene: SceneId | None = None
    scene_options: ImportOptions | None = Field(None, description="how its file is read; None: as the server does")
    size: Size | None = None
    settings: RenderSettings | None = None
    stream: Stream | None = None


class ScenePatch(Moment):
    """A change of what differs from a scene's file, as JSON Merge Patch: null takes an edit back."""

    lights: Annotated[dict[PartId, LightEdit | None], Field(max_length=MOST_PATCHED)] | None = Field(
        None, description="by id"
    )
    materials: Annotated[dict[PartId, MaterialEdit | None], Field(max_length=MOST_PATCHED)] | None = Field(
        None, description="by id"
    )
    objects: Annotated[dict[PartId, ObjectEdit | None], Field(max_length=MOST_PATCHED)] | None = Field(
        None, description="by id"
    )


class Edit(Message):
    """A change of the scene itself, for all who look at it, or for a viewer that has edits of its own."""

    type: Literal["edit"]
    id: Id
    patch: ScenePatch


class Own(Message):
    """Whether this viewer's edits are its own, or those of all."""

    type: Literal["own"]
    id: Id = Field(description="one of an edit's")
    own: bool
    share: bool = Field(False, description="those of all become what its own were, which end")


class Ack(Message):
    """The viewer has dealt with this frame and all before it."""

    type: Literal["ack"]
    frame: Id
    age_ms: Annotated[float, Field(ge=0.0, le=3.6e6)] | None = None
    decode_ms: Annotated[float, Field(ge=0.0, le=3.6e6)] | None = None
    broken: bool = Field(False, description="it could not be decoded: the next picture of the video needs no other")


AnyViewerMessage = Hello | Pose | Settings | Edit | Own | Ack
ViewerMessage = Annotated[AnyViewerMessage, Field(discriminator="type")]
_viewer_message: TypeAdapter[AnyViewerMessage] = TypeAdapter(ViewerMessage)


# --- server to viewer ------------------------------------------------------------------------------------------------


class ErrorCode(StrEnum):
    """What went wrong, for programs; the message says it for people."""

    BAD_MESSAGE = "bad-message"
    UNKNOWN_SCENE = "unknown-scene"
    LIMIT = "limit"
    SCENE_FAILED = "scene-failed"
    EDIT_REFUSED = "edit-refused"
    RENDER_FAILED = "render-failed"
    MEMORY = "memory"


class State(StrEnum):
    """What a viewer can expect now."""

    LOADING = "loading"
    READY = "ready"
    RECOVERING = "recovering"
    STOPPING = "stopping"


class SceneName(Message):
    """A scene that can be chosen."""

    id: str
    name: str
    builtin: bool = Field(description="comes with the program; else a file of the scenes folder or the served file")
    served: bool = Field(description="the one shown when none is named")


class CameraInfo(Message):
    """A camera of a scene."""

    name: str
    matrix: tuple[float, ...] = Field(description="camera to world, column-major")
    yfov: float = Field(description="vertical field of view [rad]; of an orthographic camera one that shows as much")
    aspect: float
    orthographic: bool
    near: float = Field(description="what is less far in front of the camera is cut away [m]")


class Bounds(Message):
    """The axis-aligned box, in world space, of all but what is small and far away."""

    min: tuple[float, float, float]
    max: tuple[float, float, float]


class SceneFrame(Message):
    """Where the file's coordinates are in the world: turn(metres_per_unit · (file − origin)).

    If +Z is up in the file, the turn takes +Z to +Y and +Y to −Z.
    """

    up: Axis = "y"
    metres_per_unit: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)


class LightInfo(Message):
    """A light of a scene as its file has it."""

    id: PartId
    form: LightForm
    color: Color
    added: bool = Field(False, description="a sun or a sky that the file has not, so that it is off")
    position: tuple[float, float, float] | None = Field(None, description="in the world [m], if it can be moved")
    direction: tuple[float, float, float] | None = Field(None, description="where its light goes, if it can be turned")


class MaterialInfo(Message):
    """A material of a scene as its file has it: factors on what its textures say."""

    id: PartId
    color: Color
    roughness: float
    metallic: float
    emission: tuple[float, float, float] = Field(description="radiance [W/m²/sr]")


class ObjectInfo(Message):
    """An object of a scene, all meshes of one name, and the box around it in world space, as its file has it."""

    id: PartId
    box: Bounds


class PickedPart(Message):
    """What a camera sees at one point of its picture, by the ids of the scene; None is what is not there, or not
    listed.
    """

    object: PartId | None = None
    material: PartId | None = None
    light: PartId | None = Field(None, description="that shines from there: the surface, or the sky where nothing is")
    point: Annotated[tuple[float, ...], Field(min_length=3, max_length=3)] | None = Field(
        None, description="in the world [m]"
    )
    distance: float | None = Field(None, description="of that from the camera [m]")


class AnimationInfo(Message):
    """An animation of a scene, and how long it lasts."""

    id: AnimationId
    seconds: float


class SceneInfo(Message):
    """What is known of a scene once it has been read."""

    type: Literal["scene"] = "scene"
    id: str
    name: str
    cameras: tuple[CameraInfo, ...]
    bounds: Bounds
    frame: SceneFrame = SceneFrame()
    options: ImportOptions = Field(DEFAULT_OPTIONS, description="how the file was read")
    choices: dict[str, tuple[str, ...]] = Field({}, description='what of the file can be shown: "variant", "storey"')
    lights: tuple[LightInfo, ...] = Field((), description="that can be edited")
    materials: tuple[MaterialInfo, ...] = Field((), description="that can be edited")
    objects: tuple[ObjectInfo, ...] = Field((), description="that can be edited")
    animations: tuple[AnimationInfo, ...] = Field((), description="of which edits can choose a time")
    triangles: int
    notes: tuple[str, ...] = Field((), description="what was added, ignored or changed in loading, a sentence each")


class Limits(Message):
    """What the server takes."""

    max_pixels: int = Field(description="width × height of a streamed frame")
    max_side: int = MAX_SIDE
    window: int = Field(WINDOW, description="frames that may be unacknowledged at first")
    max_message_bytes: int


class Welcome(Message):
    """The answer to hello."""

    type: Literal["welcome"] = "welcome"
    protocol: int = PROTOCOL
    viewer: int
    run: str = Field(description="of the service: another one has other edits")
    scenes: tuple[SceneName, ...]
    settings_schema: dict[str, Any] = Field(description="JSON schema of `settings`")
    codecs: tuple[CodecName, ...] = Field(description="that frames will come in, the usual one first")
    limits: Limits
    still_frames: dict[Quality, int] = Field(
        {}, description="averaged in the final picture of a still view, by quality, if the settings do not say how many"
    )
    gives_exports: bool = Field(False, description="scenes can be downloaded as GLB files")
    takes_edits: bool = Field(True, description="lights and materials can be changed")


class Edits(Message):
    """All that differs from a scene's file now."""

    type: Literal["edits"] = "edits"
    scene: str
    edits: SceneEdits
    edit: int = Field(0, description="the newest of this viewer's that was dealt with, 0: none")
    own: bool = Field(False, description="they are this viewer's own, which nobody else sees")
    suns: dict[PartId, tuple[float, float, float]] = Field(
        {}, description="where lights shine that are the sun of a date, by id"
    )
    shared_over: SceneEdits | None = Field(
        None, description="what all saw until `edit`, with which this viewer has shared its own: said once"
    )


class Status(Message):
    """What the server is doing for this viewer."""

    type: Literal["status"] = "status"
    state: State
    text: str = ""
    fraction: float = Field(0.0, ge=0.0, le=1.0)


class Error(Message):
    """Why something asked for does not happen."""

    type: Literal["error"] = "error"
    code: ErrorCode
    message: str
    edit: int = Field(0, description="of this viewer's that is refused, 0: none")


# --- checks ----------------------------------------------------------------------------------------------------------


def check_rigid(matrix: tuple[float, ...]) -> None:
    """ValueError unless a column-major 4×4 is a rotation (unit axes, right-handed) and a translation, not too far."""
    x1, x2, x3, x4, y1, y2, y3, y4, z1, z2, z3, z4, *place, one = matrix
    if max(map(abs, place)) > MAX_DISTANCE:
        raise ValueError(f"must be within {MAX_DISTANCE:g} of the origin")
    # Written out: every viewer's every pose is checked, and loops take ten times as long.
    lengths = x1 * x1 + x2 * x2 + x3 * x3 - 1.0, y1 * y1 + y2 * y2 + y3 * y3 - 1.0
    cosine = x1 * y1 + x2 * y2 + x3 * y3
    cross = x2 * y3 - x3 * y2 - z1, x3 * y1 - x1 * y3 - z2, x1 * y2 - x2 * y1 - z3
    if max(map(abs, (x4, y4, z4, one - 1.0, *lengths, cosine, *cross))) > RIGID_TOLERANCE:
        raise ValueError("must be a rotation and a translation, column after column, without scale or mirroring")


class _AnyEdit(BaseModel):
    """What is answered of an edit, whatever else it is."""

    type: Literal["edit"]
    id: Id


class BadEditError(UserError):
    """An edit that cannot be; id: by which its viewer waits for an answer."""

    def __init__(self, words: str, id_: int) -> None:
        super().__init__(words)
        self.id = id_


def parse_viewer_message(text: str | bytes) -> AnyViewerMessage:
    """The typed message in a JSON text; UserError says which field is wrong and why, BadEditError of an edit."""
    try:
        return _viewer_message.validate_json(text)
    except ValidationError as error:
        words = describe(error)
    try:
        edit = _AnyEdit.model_validate_json(text)
    except ValidationError:
        raise UserError(words) from None
    raise BadEditError(words, edit.id)


def describe(error: ValidationError) -> str:
    """The first problem of a validation in one line: the field and what it must be."""
    first = error.errors(include_url=False, include_input=False)[0]
    place = ".".join(str(part) for part in first["loc"])
    return f"{place}: {reason(first)}" if place else reason(first)
