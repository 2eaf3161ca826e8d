"""One viewer's connection: four tasks that read its messages, order frames, deliver them, and say what is going on."""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.engine import EngineState, RenderFaultError, Reply
from server.link import WorkerLostError
from server.messages import Done, Job, SceneRef
from server.protocol import (
    Ack,
    Error,
    ErrorCode,
    FrameHeader,
    Hello,
    Limits,
    Message,
    Pose,
    SceneInfo,
    Settings,
    State,
    Status,
    Welcome,
    parse_viewer_message,
    stage_slots,
)
from server.scenes import UnknownSceneError
from server.service import Service
from server.session import MAX_LOSSES, Order, Session

STATUS_SECONDS = 0.1  # at least, between two words on what is going on


async def receive(socket: WebSocket) -> str:
    """The next text message; UserError for a binary one, WebSocketDisconnect when the viewer has left."""
    message = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1005), message.get("reason"))
    text = message.get("text")
    if text is None:
        raise UserError("viewers send text messages only")
    return str(text)


class Viewer:
    """Serves one viewer whose hello was accepted."""

    def __init__(self, socket: WebSocket, service: Service, number: int, hello: Hello) -> None:
        self._socket = socket
        self._service = service
        self._hello = hello
        self._session = Session(number, hello.size, hello.settings)
        self._wanted: SceneRef | None = None  # a scene that is to be opened
        self._shown: tuple[SceneRef, SceneInfo] | None = None
        self._rendering: asyncio.Queue[tuple[Order, asyncio.Future[Reply]]] = asyncio.Queue()
        self._pending = 0  # frames ordered and not yet sent
        self._stirred = asyncio.Event()  # something changed that a task may wait for
        self._news = asyncio.Event()  # something changed that the viewer may have to be told

    async def run(self) -> None:
        """Serve until the viewer leaves."""
        await self._send(self._welcome())
        self._wanted = await self._find(self._hello.scene) or self._service.catalogue.served
        self._service.engine.listeners.add(self._news.set)
        try:
            async with asyncio.TaskGroup() as tasks:
                for task in (self._listen(), self._order(), self._deliver(), self._report()):
                    tasks.create_task(task)
        except* WebSocketDisconnect:
            pass
        finally:
            self._service.engine.listeners.discard(self._news.set)

    def _welcome(self) -> Welcome:
        limits = self._service.settings
        return Welcome(
            viewer=self._session.viewer,
            scenes=self._service.catalogue.names(),
            settings_schema=RenderSettings.model_json_schema(),
            codecs=("jpeg",),
            limits=Limits(max_pixels=limits.max_stream_pixels, max_message_bytes=limits.max_message_bytes),
        )

    # --- what the viewer says ---

    async def _listen(self) -> None:
        while True:
            try:
                message = parse_viewer_message(await receive(self._socket))
                match message:
                    case Pose():
                        self._session.pose(message)
                    case Ack():
                        self._session.acknowledge(message.frame)
                    case Settings():
                        await self._change(message)
                    case Hello():
                        raise UserError("type: hello was already said")
            except UserError as error:
                await self._fail(ErrorCode.BAD_MESSAGE, error)
            self._stir()

    async def _change(self, message: Settings) -> None:
        limits = self._service.settings
        try:
            size, settings = message.size or (1, 1), message.settings or RenderSettings()
            limits.check_render(size, settings, limits.max_stream_pixels)
        except UserError as error:
            await self._fail(ErrorCode.LIMIT, error)
            return
        scene = None if message.scene is None else await self._find(message.scene)
        if message.scene is not None and scene is None:
            return
        self._session.change(message.id, message.size, message.settings)
        if scene is not None:
            self._wanted = scene
            self._session.show(None)

    async def _find(self, scene_id: str | None) -> SceneRef | None:
        try:
            return self._service.catalogue.find(scene_id)
        except UnknownSceneError as error:
            await self._fail(ErrorCode.UNKNOWN_SCENE, error)
            return None

    # --- frames ---

    async def _order(self) -> None:
        while True:
            await self._until(lambda: self._wanted is not None or self._session.due)
            if self._wanted is not None:
                await self._open(self._wanted)
            else:
                await self._order_frame()

    async def _order_frame(self) -> None:
        orders: list[Order] = []

        def newest() -> Job | None:
            taken = self._session.take()
            if taken is None:
                return None
            order, job = taken
            orders.append(order)
            return job

        reply = await self._service.engine.submit(newest)
        if reply is not None:
            self._pending += 1
            self._rendering.put_nowait((orders[0], reply))

    async def _open(self, scene: SceneRef) -> None:
        self._news.set()
        shown = self._shown
        try:
            shown = scene, await self._read(scene)
        except (UserError, RenderFaultError, WorkerLostError) as error:
            await self._fail(ErrorCode.SCENE_FAILED, error)
        if self._wanted != scene:
            return  # the viewer has chosen another one meanwhile
        self._wanted = None
        self._shown = shown
        if shown is not None:
            self._session.show(shown[0])
            await self._send(shown[1])
        self._stir()

    async def _read(self, scene: SceneRef) -> SceneInfo:
        for _ in range(MAX_LOSSES - 1):
            with suppress(WorkerLostError):  # it may have died of something else
                return await self._service.catalogue.open(scene, self._service.engine)
        return await self._service.catalogue.open(scene, self._service.engine)

    async def _deliver(self) -> None:
        while True:
            order, reply = await self._rendering.get()
            try:
                done, image = await reply
                assert isinstance(done, Done)
                await self._socket.send_bytes(_header(order, done).pack() + image)
                self._session.delivered()
            except (UserError, RenderFaultError) as error:
                self._session.failed(order)
                await self._fail(ErrorCode.RENDER_FAILED, error)
            except WorkerLostError as error:
                if not self._session.lost(order):
                    await self._fail(ErrorCode.RENDER_FAILED, UserError(f"{error}; it dies of this view: change it"))
            self._pending -= 1
            self._stir()

    # --- what the viewer is told ---

    async def _report(self) -> None:
        told = None
        while True:
            status = self._status()
            if status != told:
                await self._send(status)
                told = status
                await asyncio.sleep(STATUS_SECONDS)
            await self._news.wait()
            self._news.clear()

    def _status(self) -> Status:
        activity = self._service.engine.activity
        words = {"text": activity.text, "fraction": activity.fraction}
        if activity.state is EngineState.READY:
            waiting = self._wanted is not None or self._pending > 0 or self._session.due
            slow = bool(activity.text) or self._wanted is not None
            return Status(state=State.LOADING, **words) if waiting and slow else Status(state=State.READY)
        return Status(state=State.LOADING if activity.state is EngineState.STARTING else State.RECOVERING, **words)

    async def _fail(self, code: ErrorCode, error: Exception) -> None:
        await self._send(Error(code=code, message=str(error)))

    async def _send(self, message: Message) -> None:
        await self._socket.send_text(message.model_dump_json())

    def _stir(self) -> None:
        self._stirred.set()
        self._news.set()

    async def _until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self._stirred.clear()
            await self._stirred.wait()


def _header(order: Order, done: Done) -> FrameHeader:
    width, height = done.size
    return FrameHeader(
        width=width,
        height=height,
        pose=order.pose,
        frame=order.frame,
        settings=order.settings,
        queue_ms=order.queue_ms,
        render_ms=done.render_ms,
        encode_ms=done.encode_ms,
        stages=stage_slots(done.stage_ms),
    )
