"""One viewer of the load: walks along a path, takes frames, acknowledges them, and logs when each came."""

import asyncio
import json
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import simplejpeg
from websockets.exceptions import ConnectionClosed

from server.wire.browser import PROTOCOL, Bounds
from server.wire.frame_header import FrameHeader, unpack_frame
from tests.load.paths import CameraPath, PathMaker, View, Walk
from tests.load.target import Socket

LOST = 1006  # RFC 6455: closed without a close frame


@dataclass(frozen=True)
class Plan:
    """What a viewer asks for and how it walks.

    hz: poses a second; scene: None is the served one; decode: really decode each picture; acknowledge: say so when it
    is shown.
    """

    size: tuple[int, int] = (1280, 720)
    hz: float = 30.0
    scene: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    stream: Mapping[str, Any] = field(default_factory=dict)
    codecs: tuple[str, ...] = ("jpeg",)
    path: PathMaker = Walk
    seed: int = 0
    decode: bool = False
    acknowledge: bool = True


@dataclass(frozen=True, slots=True)
class Seen:
    """A frame that came. Times in milliseconds from the sending of its pose; None but for the first frame of a pose.

    at: perf_counter [s]; arrived: until all its bytes were here; decoded: until the picture was decoded, if it was.
    """

    at: float
    header: FrameHeader
    size: int
    arrived: float | None
    decoded: float | None
    decode: float | None


@dataclass
class Log:
    """What happened to one viewer. `closed`: code and reason of a close by the server."""

    seen: list[Seen] = field(default_factory=list)
    errors: Counter[str] = field(default_factory=Counter)
    states: list[str] = field(default_factory=list)
    poses: int = 0
    number: int = 0
    scenes: int = 0
    closed: tuple[int, str] | None = None

    @property
    def last(self) -> float:
        """When the last frame came, 0 before the first."""
        return self.seen[-1].at if self.seen else 0.0


class Viewer:
    """A viewer on an open socket. `log` grows while it runs."""

    def __init__(self, socket: Socket, plan: Plan, now: Callable[[], float] = perf_counter) -> None:
        self.log = Log()
        self._socket = socket
        self._plan = plan
        self._now = now
        self._path: CameraPath | None = None
        self._began = 0.0
        self._sent: dict[int, float] = {}  # when each pose was sent that no frame has named yet
        self._settings = 0
        self._came: asyncio.Queue[tuple[float, FrameHeader, bytes]] = asyncio.Queue()

    async def run(self) -> None:
        """Say hello and walk until the server closes or this is cancelled."""
        try:
            async with asyncio.TaskGroup() as tasks:
                for task in (self._listen(), self._walk(), self._show()):
                    tasks.create_task(task)
        except* ConnectionClosed:
            self.log.closed = (self._socket.close_code or LOST, self._socket.close_reason or "")

    async def change(self, **fields: Any) -> None:
        """Send a settings message with these fields."""
        self._settings += 1
        if "scene" in fields:
            self._path = None  # poses are meant for the scene that is shown
        await self._send("settings", id=self._settings, **fields)

    async def _walk(self) -> None:
        last: View | None = None
        step = 1.0 / self._plan.hz
        tick = self._now() + step * (self._plan.seed * 0.618 % 1.0)  # viewers do not walk in step
        while True:
            await asyncio.sleep(max(tick - self._now(), 0.0))
            tick = max(tick + step, self._now() - step)
            if self._path is None:
                continue
            view = self._path.at(self._now() - self._began)
            if view != last:  # a camera that rests is not sent
                last = view
                self.log.poses += 1
                self._sent[self.log.poses] = self._now()
                await self._send("pose", id=self.log.poses, matrix=view.matrix, yfov=view.yfov)

    async def _listen(self) -> None:
        plan = self._plan
        scene = {} if plan.scene is None else {"scene": plan.scene}
        wishes = {"settings": plan.settings, "stream": plan.stream, "codecs": plan.codecs}
        await self._send("hello", protocol=PROTOCOL, size=plan.size, **wishes, **scene)
        while True:
            message = await self._socket.recv()
            now = self._now()
            if isinstance(message, bytes):
                self._came.put_nowait((now, *unpack_frame(message)))
            else:
                self._hear(json.loads(message))

    def _hear(self, word: dict[str, Any]) -> None:
        match word["type"]:
            case "welcome":
                self.log.number = word["viewer"]
            case "scene":
                self.log.scenes += 1
                self._path = self._plan.path(Bounds(**word["bounds"]), self._plan.seed)
                self._began = self._now()
            case "status":
                self.log.states.append(word["state"])
            case "error":
                self.log.errors[f"{word['code']}: {word['message']}"] += 1

    async def _show(self) -> None:
        while True:
            at, header, image = await self._came.get()
            sent = self._sent.get(header.pose)
            decoded = decode = None
            if self._plan.decode:
                began = self._now()
                await asyncio.to_thread(_decode, image, header)
                decode = 1e3 * (self._now() - began)
            if sent is not None:
                self._sent = {pose: time for pose, time in self._sent.items() if pose > header.pose}
                decoded = 1e3 * (self._now() - sent) if self._plan.decode else None
            arrived = 1e3 * (at - sent) if sent is not None else None
            self.log.seen.append(Seen(at, header, len(image), arrived, decoded, decode))
            if self._plan.acknowledge:
                age = decoded if decoded is not None else arrived
                told = {"age_ms": age, "decode_ms": decode} if age is not None and age >= 0.0 else {}
                await self._send("ack", frame=header.frame, **told)

    async def _send(self, type_: str, **fields: Any) -> None:
        await self._socket.send(json.dumps({"type": type_} | fields))


def _decode(image: bytes, header: FrameHeader) -> None:
    height, width, _ = simplejpeg.decode_jpeg(image).shape
    if (width, height) != (header.width, header.height):
        raise ValueError(f"frame {header.frame} says {header.width}×{header.height} and is {width}×{height}")
