"""One viewer: tasks that read its messages, ask for frames and send them, say what is going on, and end it."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from time import monotonic
from typing import Any, NamedTuple

from fastapi import WebSocketDisconnect

from gpu.errors import OutOfMemoryError, UserError
from gpu.sample_counts import usual_counts
from gpu.scene.edits import SceneEdits
from gpu.scene.import_options import ImportOptions
from gpu.settings import Quality, RenderSettings
from server.http.metered import Metered
from server.rate_limit import Bucket
from server.refusals import TooBusyError, UnknownSceneError
from server.render.activity import EngineState
from server.render.pending import RenderFaultError, Reply
from server.render.schedule import Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.service import Service
from server.video.live_video import can_encode_video
from server.walk.frame_request import FrameRequest
from server.walk.frame_times import FrameTimes
from server.walk.session import MAX_LOSSES, Qualities, Session
from server.walk.stirring import Stirring
from server.walk.viewer_socket import ViewerSocket
from server.wire.browser import (
    Ack,
    BadEditError,
    CodecName,
    Edit,
    Edits,
    Error,
    ErrorCode,
    Hello,
    Limits,
    Own,
    Pose,
    SceneInfo,
    Settings,
    State,
    Status,
    Welcome,
    parse_viewer_message,
)
from server.wire.worker import Done, Job, SceneRef

STATUS_SECONDS = 0.1  # at least, between two words on what is going on
# And between two on what differs from the scene's file, which may be long: so many characters a second [1/s].
EDITS_SECONDS, EDITS_RATE = 0.05, 1e6
STALLED_SECONDS = 10.0
WATCH_SECONDS = 1.0
LEFT_SECONDS = 1.0  # in which a scene is still read after the viewer has chosen another one: so it begins few of them
STALLED, RESTART = 1013, 1012  # the codes of a close: both say that a viewer may come back
MESSAGE_RATE, MESSAGE_BURST = 600.0, 100.0  # messages a second, and at once: poses and acknowledgements at 240 Hz pass
FAULT_RATE, FAULT_BURST = 0.5, 5.0  # and so many of a viewer's mistakes
log = logging.getLogger("lumenwalk.viewer")


class _State(NamedTuple):
    """What the server is doing for a viewer: the fields of `Status`, which takes ten times as long to make."""

    state: State
    text: str = ""
    fraction: float = 0.0


_READY = _State(State.READY)


class Viewer:
    """Serves one viewer whose hello was accepted; charge: hears what its messages take (server.http.metered)."""

    def __init__(
        self,
        socket: ViewerSocket,
        service: Service,
        number: int,
        hello: Hello,
        charge: Callable[[float], None],
    ) -> None:
        self._socket = socket
        self._service = service
        self._hello = hello
        self._charge = charge
        here: tuple[CodecName, ...] = ("png", "h264") if can_encode_video() else ("png",)
        self._codecs: tuple[CodecName, ...] = ("jpeg", *(name for name in here if name in hello.codecs))
        settings = service.settings
        self._session = Session(
            number,
            hello.size,
            hello.settings,
            stream=hello.stream,
            qualities=Qualities(settings.jpeg_quality, settings.still_quality),
            codecs=self._codecs,
            on_gpu=service.engines.cuda,
        )
        self._times = FrameTimes(service.metrics)
        self._wanted: SceneRef | None = None  # a scene that is to be opened
        self._reading: tuple[SceneRef, asyncio.Timeout] | None = None  # which is read, and until when
        self._shown: tuple[SceneRef, SceneInfo] | None = None
        self._tried: SceneRef | None = None  # what the file of the shown one has become, which was or is to be opened
        self._problem: UserError | None = None  # why that cannot be, of which the viewer is to be told
        self._last_edit = 0  # of this viewer's that was dealt with
        self._shared_over: SceneEdits | None = None  # what that has replaced, of which the viewer is to be told
        self._edits_changed = asyncio.Event()
        self._rendering: asyncio.Queue[tuple[FrameRequest, float, asyncio.Future[Reply]]] = asyncio.Queue()
        self._messages = Bucket(MESSAGE_RATE, MESSAGE_BURST)
        self._faults = Bucket(FAULT_RATE, FAULT_BURST)
        self._awaited = 0  # frames asked for and not yet sent, but for those that refine
        self._stirring = Stirring(lambda: self._session.rest_seconds)  # a view that comes to rest stirs nothing
        self._news = asyncio.Event()  # something changed that the viewer may have to be told
        self._told: _State | None = None  # of what is going on

    async def run(self) -> None:
        """Serve until the viewer leaves."""
        await self._service.catalogue.refresh()
        await self._socket.send(self._welcome())
        self._wanted = await self._find(self._hello.scene, self._hello.scene_options)
        if self._wanted is None and self._hello.scene is not None:
            self._wanted = await self._find(None)
        self._service.engines.listeners.add(self._news.set)
        self._service.edited.listeners.add(self._edited)
        self._service.changed_files.listeners.add(self._file_changed)
        try:
            async with asyncio.TaskGroup() as tasks:
                for task in (
                    self._listen(),
                    self._request_frames(),
                    self._deliver(),
                    self._report(),
                    self._tell_edits(),
                    self._watch(),
                    self._stop(),
                ):
                    tasks.create_task(task)
        except* WebSocketDisconnect as group:
            # Several tasks may notice; the first of them knows why.
            end = next((end for end in group.exceptions if isinstance(end, WebSocketDisconnect)), None)
            if end is not None:
                log.info("viewer left", extra={"code": end.code, "reason": end.reason})
        finally:
            self._service.engines.listeners.discard(self._news.set)
            self._service.edited.listeners.discard(self._edited)
            self._service.changed_files.listeners.discard(self._file_changed)
            self._service.edited.end_own(self._session.viewer)
            while not self._rendering.empty():
                self._rendering.get_nowait()[2].cancel()
            self._service.metrics.windows.pop(self._session.viewer, None)

    def _welcome(self) -> Welcome:
        limits = self._service.settings
        return Welcome(
            viewer=self._session.viewer,
            run=self._service.run,
            scenes=self._service.catalogue.names(),
            settings_schema=settings_schema(),
            codecs=self._codecs,
            still_frames={it: usual_counts(it, cuda=self._service.engines.cuda).frames for it in Quality},
            takes_edits=limits.edits,
            gives_exports=limits.exports,
            limits=Limits(max_pixels=limits.max_stream_pixels, max_message_bytes=limits.max_message_bytes),
        )

    # --- what the viewer says ---

    async def _listen(self) -> None:
        """What messages take to be dealt with, up to telling all who look, is charged to who sends them."""
        await Metered(self._hear(), self._charge)

    async def _hear(self) -> None:
        while True:
            if (seconds := self._messages.take()) > 0.0:
                await asyncio.sleep(seconds)  # and meanwhile nothing is read: TCP holds the rest back
            try:
                message = parse_viewer_message(await self._socket.receive())
                match message:
                    case Pose():
                        self._session.pose(message)
                    case Ack():
                        self._session.acknowledge(message.frame, broken=message.broken)
                        self._times.acknowledged(message)
                    case Settings():
                        await self._change(message)
                    case Edit() | Own():
                        await self._edit(message)
                    case Hello():
                        raise UserError("type: hello was already said")
            except BadEditError as error:
                await self._refuse_edit(error, error.id)
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
        scene = None
        if message.scene is not None or message.scene_options is not None:
            scene = await self._find(message.scene or self._scene_id, message.scene_options)
            if scene is None:
                return
        self._session.change(message.id, message.size, message.settings, message.stream)
        if scene is not None:
            self._wanted = scene
            self._session.show(None)
            self._leave_or_stay(scene)

    def _leave_or_stay(self, scene: SceneRef) -> None:
        """What is read is waited for no longer than LEFT_SECONDS, unless it is what was chosen last."""
        if self._reading is None or self._reading[1].expired():
            return
        read, until = self._reading
        if read == scene:
            until.reschedule(None)
        elif until.when() is None:
            until.reschedule(asyncio.get_running_loop().time() + LEFT_SECONDS)

    async def _edit(self, message: Edit | Own) -> None:
        edited, viewer = self._service.edited, self._session.viewer
        try:
            if self._shown is None or self._wanted is not None:
                raise UserError("no scene is open that could be edited")
            self._service.check_edits(viewer)
            if isinstance(message, Edit):
                edited.change(*self._shown, message.patch, viewer)
            elif message.own:
                edited.begin_own(self._shown[0], viewer)
            else:
                before = edited.of(self._shown[0])
                if edited.end_own(viewer, share=message.share):
                    self._shared_over = before
            self._edited(self._shown[0])
        except (UserError, TooBusyError) as error:
            await self._refuse_edit(error, message.id)
        else:
            self._dealt_with(message.id)

    async def _refuse_edit(self, error: Exception, number: int) -> None:
        await self._fail(ErrorCode.EDIT_REFUSED, error, edit=number)
        self._dealt_with(number)

    def _dealt_with(self, number: int) -> None:
        self._last_edit = number
        self._edits_changed.set()

    def _edited(self, scene: SceneRef) -> None:
        """Somebody has edited a scene."""
        if self._shown is not None and self._shown[0] == scene == self._session.scene:
            edited, viewer = self._service.edited, self._session.viewer
            if self._session.edit(edited.of(scene, viewer), own=edited.is_own(scene, viewer)):
                self._edits_changed.set()
                self._stir()

    def _file_changed(self, scene: SceneRef, newest: SceneRef, problem: UserError | None) -> None:
        """The file of a scene is another one now: who looks at it sees that, or hears what is wrong with it."""
        if self._shown is None or self._shown[0] != scene or self._wanted is not None or self._tried == newest:
            return
        self._tried = newest
        if problem is None:
            log.info("the scene's file has changed", extra={"scene": scene.id})
            self._wanted = newest
            self._session.show(None)
            self._stir()
        else:
            self._problem = problem
            self._news.set()

    @property
    def _scene_id(self) -> str | None:
        """Of the scene that is wanted last."""
        if self._wanted is not None:
            return self._wanted.id
        return self._shown[0].id if self._shown is not None else None

    async def _find(self, scene_id: str | None, options: ImportOptions | None = None) -> SceneRef | None:
        try:
            return await self._service.catalogue.look_up(scene_id, options)
        except UnknownSceneError as error:
            await self._fail(ErrorCode.UNKNOWN_SCENE, error)
            return None

    # --- frames ---

    async def _request_frames(self) -> None:
        while True:
            await self._stirring.until(lambda: self._wanted is not None or self._session.due is not None)
            if self._wanted is not None:
                await self._open(self._wanted)
            else:
                await self._request_frame()

    async def _request_frame(self) -> None:
        urgency, scene = self._session.due, self._session.scene
        if urgency is None or scene is None:
            return
        requests: list[tuple[FrameRequest, float]] = []
        asked = monotonic()

        def newest() -> Job | None:
            taken = self._session.take()
            if taken is None:
                return None
            request, job = taken
            requests.append((request, 1e3 * (monotonic() - asked)))
            return job

        turn = self._service.engines.submit(self._session.viewer, scene, urgency, newest)
        turn.add_done_callback(lambda _: self._stirring.stir())
        try:
            await self._stirring.until(lambda: turn.done() or (not requests and self._overtaken(urgency)))
            reply = turn.result() if turn.done() else None
        finally:
            turn.cancel()
        if reply is not None:
            request, waited_ms = requests[0]
            self._awaited += not request.refines
            self._rendering.put_nowait((request, waited_ms, reply))

    def _overtaken(self, urgency: Urgency) -> bool:
        """Whether what is wanted now must not wait for a turn of this urgency."""
        due = self._session.due
        return self._wanted is not None or (due is not None and due < urgency)

    async def _open(self, scene: SceneRef) -> None:
        self._news.set()
        shown, failure = self._shown, None
        reading = asyncio.timeout(None)
        self._reading = scene, reading
        try:
            async with reading:
                shown = scene, await self._read(scene)
        except (UserError, TooBusyError, RenderFaultError, WorkerLostError) as error:
            failure = error
        except TimeoutError:
            if not reading.expired():
                raise
            return  # to the one that the viewer has chosen meanwhile
        finally:
            self._reading = None
        if self._wanted != scene:
            return  # the viewer has chosen another one meanwhile
        self._wanted = None
        if failure is not None:
            await self._fail(ErrorCode.SCENE_FAILED, failure)
        self._shown = shown
        if shown is not None:
            self._service.edited.end_own(self._session.viewer)
            self._shared_over = None
            self._service.viewing[self._session.viewer] = shown[0]
            self._session.show(shown[0], self._service.edited.of(shown[0]))
            await self._socket.send(shown[1])
            self._edits_changed.set()
        self._stir()

    async def _read(self, scene: SceneRef) -> SceneInfo:
        for _ in range(MAX_LOSSES - 1):
            with suppress(WorkerLostError):  # it may have died of something else
                return await self._service.residency.open(scene, self._session.viewer)
        return await self._service.residency.open(scene, self._session.viewer)

    async def _deliver(self) -> None:
        while True:
            request, waited_ms, reply = await self._rendering.get()
            try:
                done, image = await reply
                assert isinstance(done, Done)
                self._session.delivered(request, done, waited_ms)
                if request.frame is not None:
                    await self._show(request, done, image)
            except OutOfMemoryError as error:
                smaller = self._session.shrink(request)
                words = f"{error}; it is shown smaller" if smaller else str(error)
                await self._fail(ErrorCode.MEMORY if smaller else ErrorCode.RENDER_FAILED, UserError(words))
            except (UserError, RenderFaultError) as error:
                if self._session.failed(request):  # of several under way, the first to fail is told
                    await self._fail(ErrorCode.RENDER_FAILED, error)
            except WorkerLostError as error:
                innocent = isinstance(error, InnocentLossError)
                if not self._session.lost(request, innocent=innocent):
                    await self._fail(ErrorCode.RENDER_FAILED, UserError(f"{error}; it dies of this view: change it"))
            self._awaited -= not request.refines
            self._stir()

    async def _show(self, request: FrameRequest, done: Done, image: bytes) -> None:
        header = request.header(done)
        message = header.pack() + image
        self._session.sent(header, len(message))
        self._times.sending(header)
        await self._socket.send_frame(message)
        self._times.sent(header, done, len(message))
        self._service.metrics.windows[self._session.viewer] = self._session.window.limit

    async def _watch(self) -> None:
        """Drop a viewer that acknowledges nothing any more: it does not read, and what it is sent only piles up."""
        while self._session.window.waiting_seconds < STALLED_SECONDS:
            await asyncio.sleep(WATCH_SECONDS)
        self._service.metrics.dropped("stalled")
        await self._socket.leave(STALLED, f"no frame was acknowledged for {STALLED_SECONDS:.0f} s")

    async def _stop(self) -> None:
        """Tell the viewer that the service ends, and close."""
        await self._service.stopping.wait()
        await self._socket.say_goodbye(Status(state=State.STOPPING, text="the server is stopping"))
        await self._socket.leave(RESTART, "the server is stopping")

    # --- what the viewer is told ---

    async def _report(self) -> None:
        while True:
            if (problem := self._problem) is not None:
                self._problem = None
                await self._fail(ErrorCode.SCENE_FAILED, problem)
            if (state := self._state) != self._told:
                await self._socket.send(Status(state=state.state, text=state.text, fraction=state.fraction))
                self._told = state
                await asyncio.sleep(STATUS_SECONDS)
            else:
                await self._news.wait()
            self._news.clear()

    async def _tell_edits(self) -> None:
        while True:
            await self._edits_changed.wait()
            self._edits_changed.clear()
            size = 0
            if self._shown is not None:
                scene, edited, viewer = self._shown[0], self._service.edited, self._session.viewer
                edits, own = edited.of(scene, viewer), edited.is_own(scene, viewer)
                suns = {
                    one: it.shines for one, it in edits.lights.items() if it.sun is not None and it.shines is not None
                }
                over, self._shared_over = self._shared_over, None
                size = await self._socket.send(
                    Edits(scene=scene.id, edits=edits, edit=self._last_edit, own=own, suns=suns, shared_over=over)
                )
            await asyncio.sleep(max(EDITS_SECONDS, size / EDITS_RATE))

    @property
    def _state(self) -> "_State":
        activity = self._service.engines.activity_of(self._session.viewer)
        words = activity.text, activity.fraction
        if activity.state is not EngineState.READY:
            return _State(State.LOADING if activity.state is EngineState.STARTING else State.RECOVERING, *words)
        if not activity.text and self._wanted is None:
            return _READY
        waits = self._wanted is not None or self._awaited > 0 or self._session.due in (Urgency.MOVING, Urgency.STILL)
        return _State(State.LOADING, *words) if waits else _READY

    async def _fail(self, code: ErrorCode, error: Exception, edit: int = 0) -> None:
        if code is not ErrorCode.BAD_MESSAGE and self._faults.spend():
            log.warning("%s: %s", code, error)
        await self._socket.send(Error(code=code, message=str(error), edit=edit))

    def _stir(self) -> None:
        self._stirring.stir()
        if self._state != self._told:
            self._news.set()


@cache
def settings_schema() -> dict[str, Any]:
    """What settings there are. It takes 10 ms of a core to make, in which nobody else is served."""
    return RenderSettings.model_json_schema()
