"""The border between the web process and the worker process: small typed messages, and bytes; nothing else crosses.

On the wire a message is two little-endian u32 lengths, then its JSON, then raw bytes (an encoded image, often none).
JSON that pydantic checks on arrival, rather than pickle: the worker runs native code on files that users bring, so
what it sends must not be able to run anything in the web process. Its cost, some 20 µs, is small beside a frame.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from typing import Annotated, Any, BinaryIO, Literal, Protocol

from pydantic import Field, TypeAdapter

from gpu.scene.edits import NO_EDITS, SceneEdits
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.lighting.environment_options import NO_ENVIRONMENT, EnvironmentOptions
from gpu.scene.limits import MOST_BESIDE, SceneLimits
from gpu.settings import RenderSettings
from server.wire.browser import PickedPart, SceneInfo
from server.wire.log_format import LogFormat

STILLS = 0  # the viewer number of renders that no viewer asked for; viewers count from 1
HEARTBEAT = -1  # the viewer number of renders that only see whether the device still works
START_UP = 0  # the request number of the start; requests count from 1
MAX_EXPORT_BYTES = 2**28
MAX_TEXT_BYTES = 2**24  # of a message's JSON; the largest by far says what is in a scene

# "none": rendered, not encoded; "jpeg": of the quality asked for, made for speed; "h264": the next picture of the
# viewer's video; "rgb": the bytes of sRGB pixels.
Output = Literal["none", "jpeg", "h264", "rgb", ".png", ".jpg", ".exr", ".npy"]
Vector = tuple[float, float, float]
Name = Annotated[str, Field(min_length=1, max_length=32)]
Milliseconds = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
StageTimes = Annotated[dict[Name, Milliseconds], Field(max_length=64)]  # they must fit into a frame's header


@dataclass(frozen=True)
class SceneRef:
    """A scene as the worker finds it: public id, file or built-in name, and how that is read.

    A file that changed has another stamp.
    """

    id: str
    source: str
    stamp: int = 0
    options: ImportOptions = DEFAULT_OPTIONS


@dataclass(frozen=True)
class SceneCamera:
    """One of the scene's own cameras, by index or name."""

    camera: int | str


@dataclass(frozen=True)
class LookAt:
    """A perspective view from position to target, in the file's coordinates; up: None is the scene's.

    near: what is less far in front of the camera is cut away [m].
    """

    position: Vector
    target: Vector
    up: Vector | None
    yfov_degrees: float
    near: float = 0.0


@dataclass(frozen=True)
class CameraMatrix:
    """A perspective view by its camera-to-world matrix (16 numbers, column-major) and vertical field of view [rad].

    near: what is less far in front of the camera is cut away [m].
    """

    matrix: tuple[float, ...]
    yfov: float
    near: float = 0.0


View = SceneCamera | LookAt | CameraMatrix


@dataclass(frozen=True)
class AlongPath:
    """Where a camera is at a time [s] that passes each view at its own; their times increase."""

    keyframes: tuple[tuple[float, View], ...]
    time: float


CameraSpec = View | AlongPath

# --- to the worker ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Start:
    """The first message: what the worker serves, its limits, and what is around every scene."""

    scene: SceneRef
    device: str | None = None
    max_scenes: int = 4
    scene_limits: SceneLimits = field(default_factory=SceneLimits)
    check_seconds: float = 25.0
    check_memory_bytes: int = 8 * 2**30
    environment: EnvironmentOptions = NO_ENVIRONMENT
    log_format: LogFormat = LogFormat.TEXT
    kind: Literal["start"] = "start"


@dataclass(frozen=True)
class OpenScene:
    """Read a scene; answered by Free, then Opened, or by Failed, then Free.

    packed: where it is as it was read by another process (server.scenes.packed_scene), if it is.
    """

    scene: SceneRef
    request: int = 0
    packed: str = ""
    kind: Literal["open"] = "open"


@dataclass(frozen=True)
class Render:
    """Render one picture for a viewer (or STILLS, HEARTBEAT); answered by Free and Done, or by Failed, then Free.

    sample: None is a frame by itself. Otherwise the frame is averaged with that many earlier ones of this view; 0
    starts anew. If the worker does not have those, it starts anew too, which Done.samples tells. walks: it is one of
    many on a viewer's way, so it may build on the one before; else it depends on nothing but what is said here. edits:
    all that differs from the scene's file, so that no worker has to remember them; own: for this viewer alone.
    video: the picture's number in the viewer's video; after one that was not the one before, it is a key frame.
    """

    viewer: int
    scene: SceneRef
    view: CameraSpec
    size: tuple[int, int]
    settings: RenderSettings
    output: Output
    sample: int | None = None
    walks: bool = False
    quality: int = 85
    edits: SceneEdits = NO_EDITS
    own: bool = False
    video: int = 0
    request: int = 0
    kind: Literal["render"] = "render"


@dataclass(frozen=True)
class Pick:
    """Say what a camera sees at `place` in [0, 1]² of a picture of `size`, from its top left; answered by Free, then
    Picked, or by Failed, then Free. edits: as of Render.
    """

    scene: SceneRef
    view: CameraSpec
    size: tuple[int, int]
    place: tuple[float, float]
    edits: SceneEdits = NO_EDITS
    request: int = 0
    kind: Literal["pick"] = "pick"


@dataclass(frozen=True)
class Export:
    """Write a scene as a GLB file, of MAX_EXPORT_BYTES at most; answered by Free and Exported, or by Failed, then Free.

    edits: as of Render.
    """

    scene: SceneRef
    edits: SceneEdits = NO_EDITS
    request: int = 0
    kind: Literal["export"] = "export"


@dataclass(frozen=True)
class Leave:
    """A viewer is gone: free what is kept for it. Not answered."""

    viewer: int
    kind: Literal["leave"] = "leave"


@dataclass(frozen=True)
class CloseScene:
    """Free a scene and all that was made for it; answered by Free, then Closed."""

    scene: SceneRef
    request: int = 0
    kind: Literal["close"] = "close"


@dataclass(frozen=True)
class Yield:
    """Others wait for the turn that a job has: answered by Paused, unless the job ends first."""

    request: int
    kind: Literal["yield"] = "yield"


@dataclass(frozen=True)
class Resume:
    """Go on with a job that has paused; answered as the job, or by Paused."""

    request: int
    kind: Literal["resume"] = "resume"


@dataclass(frozen=True)
class Cancel:
    """Nobody wants a job any more: it ends at its next pause, or when it goes on, by Failed and Free."""

    request: int
    kind: Literal["cancel"] = "cancel"


Job = OpenScene | CloseScene | Render | Pick | Export
ToWorker = Start | OpenScene | Render | Pick | Export | Leave | CloseScene | Yield | Resume | Cancel

# --- from the worker -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Holdings:
    """What the device holds now: scenes, the longest unused first; memory_total is 0 where it is not known [bytes]."""

    memory_used: int
    memory_total: int
    scenes: tuple[SceneRef, ...]


@dataclass(frozen=True)
class Ready:
    """Kernels are loaded and a frame was rendered. lanes: how many jobs the worker takes at once."""

    device: str
    holdings: Holdings
    lanes: Annotated[int, Field(ge=1, le=64)] = 1
    kind: Literal["ready"] = "ready"


@dataclass(frozen=True)
class Progress:
    """What takes long now, and how far it is."""

    text: str
    fraction: Annotated[float, Field(ge=0.0, le=1.0)]
    kind: Literal["progress"] = "progress"


@dataclass(frozen=True)
class Free:
    """The worker can take another job; this one's answer may still be on its way (being encoded).

    busy_ms: time that the job had the device in this turn, a share where others had theirs at once. A job that has
    paused may end in the turn of another that waits for it.
    """

    request: int
    busy_ms: Milliseconds
    holdings: Holdings
    kind: Literal["free"] = "free"


@dataclass(frozen=True)
class Paused:
    """The worker can take another job; this one is to be resumed. busy_ms: time that it had the device in this turn."""

    request: int
    busy_ms: Milliseconds
    holdings: Holdings
    kind: Literal["paused"] = "paused"


@dataclass(frozen=True)
class Opened:
    """Answer to OpenScene. beside: as of gpu.scene.types.LoadReport."""

    request: int
    info: SceneInfo
    beside: Annotated[dict[str, int], Field(max_length=MOST_BESIDE)] = field(default_factory=dict)
    kind: Literal["opened"] = "opened"


@dataclass(frozen=True)
class Closed:
    """Answer to CloseScene."""

    request: int
    kind: Literal["closed"] = "closed"


@dataclass(frozen=True)
class Done:
    """Answer to Render, with the encoded image as the message's bytes; times in milliseconds.

    samples: frames averaged in it; target: of how many the settings, or the device, want a still view to be.
    is_key: whether the image can be decoded without an earlier one.
    """

    request: int
    size: tuple[int, int]
    render_ms: float
    encode_ms: float
    samples: int
    target: int
    stage_ms: StageTimes
    counts: dict[str, int]
    skips: dict[str, int]
    estimates: dict[str, float] = field(default_factory=dict)
    is_key: bool = True
    kind: Literal["done"] = "done"


@dataclass(frozen=True)
class Picked:
    """Answer to Pick."""

    request: int
    part: PickedPart
    kind: Literal["picked"] = "picked"


@dataclass(frozen=True)
class Exported:
    """Answer to Export, with the file as the message's bytes."""

    request: int
    kind: Literal["exported"] = "exported"


class Cause(StrEnum):
    """Whose fault a failure is: the user's, that of a device with too little memory, or the program's."""

    USER = "user"
    MEMORY = "memory"
    PROGRAM = "program"


@dataclass(frozen=True)
class Failed:
    """Answer to any request; the text explains it to the user, unless the program is at fault: then the log does."""

    request: int
    text: str
    cause: Cause
    kind: Literal["failed"] = "failed"


FromWorker = Ready | Progress | Free | Paused | Opened | Closed | Done | Picked | Exported | Failed

# --- the codec -------------------------------------------------------------------------------------------------------

_Message = Annotated[ToWorker | FromWorker, Field(discriminator="kind")]
_adapter: TypeAdapter[ToWorker | FromWorker] = TypeAdapter(_Message)
_lengths = struct.Struct("<II")


@cache
def _adapter_of(kind: type) -> TypeAdapter[Any]:
    """Of one type: to look for the one that fits takes as long as to write it. Made when one is sent, as few are."""
    return TypeAdapter(kind)


def pack(message: ToWorker | FromWorker, payload: bytes = b"") -> bytes:
    """A message and its bytes, ready for the pipe; ValueError for what the other side would not take."""
    kind: type = type(message)
    text = _adapter_of(kind).dump_json(message)
    if len(text) > MAX_TEXT_BYTES:
        raise ValueError(f"{len(text)} bytes of text are more than a message may have: {message.kind}")
    return b"".join((_lengths.pack(len(text), len(payload)), text, payload))


def read(pipe: BinaryIO) -> tuple[ToWorker | FromWorker, bytes]:
    """The next message from a blocking pipe; EOFError when the other side is gone."""
    lengths = pipe.read(_lengths.size)
    if len(lengths) < _lengths.size:
        raise EOFError
    text, payload = _lengths.unpack(lengths)
    body = pipe.read(text + payload)
    if len(body) < text + payload:
        raise EOFError
    return _adapter.validate_json(body[:text]), body[text:]


class ByteStream(Protocol):
    """What is wanted of an asyncio.StreamReader: workers, which have none, start sooner without that module."""

    async def readexactly(self, n: int) -> bytes:
        """So many bytes, or IncompleteReadError."""
        ...


async def receive(stream: ByteStream, most_bytes: Callable[[], int]) -> tuple[ToWorker | FromWorker, bytes]:
    """The next message from an asyncio stream.

    Raises EOFError (IncompleteReadError) when the other side is gone, and ValueError for what is no message or larger
    than one: its JSON than MAX_TEXT_BYTES, its bytes than `most_bytes` allows now.
    """
    text, payload = _lengths.unpack(await stream.readexactly(_lengths.size))
    if text > MAX_TEXT_BYTES or (payload and payload > most_bytes()):
        raise ValueError(f"{text} bytes of text and {payload} of image are too many")
    return _adapter.validate_json(await stream.readexactly(text)), await stream.readexactly(payload)
