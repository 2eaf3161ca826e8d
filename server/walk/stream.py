"""The WebSocket endpoint: admits a viewer and reads its messages. server.wire.browser describes the wire."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from fastapi import APIRouter, Response, WebSocket, WebSocketDisconnect
from starlette.routing import WebSocketRoute

from gpu.errors import UserError
from server.errors import error_response, refusals
from server.http.metered import charger
from server.logs import bind
from server.places import asker
from server.service import Service
from server.walk.viewer import RESTART, Viewer
from server.walk.viewer_socket import ViewerSocket
from server.wire.browser import SUBPROTOCOL, Error, ErrorCode, Hello, parse_viewer_message

HELLO_SECONDS = 5.0
MAX_GREETING = 256  # who may have said nothing yet
BAD_PROTOCOL, POLICY, FAULT, TRY_AGAIN = 1002, 1008, 1011, 1013

log = logging.getLogger("lumenwalk.viewer")
router = APIRouter()
PATH = "/api/v1/stream"


@router.get(PATH, operation_id="walk", responses=refusals(426), status_code=101, response_class=Response)
async def no_stream() -> Response:
    """Walks are WebSockets (RFC 6455, version 13): this is where a handshake goes. Any other request gets 426."""
    response = error_response(426, "upgrade-required", "walks are WebSockets, of version 13: this asks for none")
    response.headers.update({"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"})
    return response


async def stream(socket: WebSocket) -> None:
    """Serve one viewer until it leaves."""
    service: Service = socket.app.state.service
    # A browser that offers subprotocols, one of which may be its token, wants one of them taken.
    await socket.accept(SUBPROTOCOL if SUBPROTOCOL in socket.scope["subprotocols"] else None)
    if service.stopping.is_set():
        await _refuse(socket, service, "stopping", RESTART, "the server is stopping")
        return
    if service.full:
        await _refuse_as_full(socket, service)
        return
    if service.efforts.empty(asker.get()):
        text = "what you asked for took too much of this server's time; try again later"
        await _refuse(socket, service, "effort", TRY_AGAIN, text)
        return
    try:
        hello = await _greet(socket, service)
    except WebSocketDisconnect:
        return
    if hello is None:
        service.metrics.refused("hello")
        return
    number = service.admit()
    if number is None:
        await _refuse_as_full(socket, service)
        return
    bind(viewer=number)
    log.info("viewer came", extra={"address": socket.client.host if socket.client else ""})
    try:
        await Viewer(ViewerSocket(socket), service, number, hello, charger(socket.scope, service)).run()
    except WebSocketDisconnect:
        pass
    except Exception:
        log.exception("a viewer is closed after a fault in the web process")
        service.metrics.dropped("fault")
        with suppress(WebSocketDisconnect, RuntimeError):
            await socket.close(FAULT, "an internal error; the server's log has the details")
    finally:
        service.dismiss(number)


ROUTE = WebSocketRoute(PATH, stream)  # Starlette's: FastAPI's looks at the endpoint's parameters each time


async def _refuse_as_full(socket: WebSocket, service: Service) -> None:
    text = f"{len(service.viewers)} viewers are here, as many as may be, or as many of yours; try again later"
    await _refuse(socket, service, "full", TRY_AGAIN, text)


async def _refuse(socket: WebSocket, service: Service, reason: str, code: int, text: str) -> None:
    service.metrics.refused(reason)
    with suppress(WebSocketDisconnect):
        await socket.close(code, text)


@asynccontextmanager
async def _greeting(service: Service, deadline: asyncio.Timeout) -> AsyncIterator[None]:
    """Who says nothing takes no viewer's place; of too many, who came first makes room for who comes."""
    silent = service.greeting
    silent.append(deadline)
    if len(silent) > MAX_GREETING and not (oldest := silent.pop(0)).expired():
        oldest.reschedule(asyncio.get_running_loop().time())
    try:
        yield
    finally:
        if deadline in silent:
            silent.remove(deadline)


async def _greet(socket: WebSocket, service: Service) -> Hello | None:
    """The viewer's hello; None when there is none that can be served, and then the socket is closed."""
    code, close = ErrorCode.BAD_MESSAGE, BAD_PROTOCOL
    try:
        async with asyncio.timeout(HELLO_SECONDS) as deadline, _greeting(service, deadline):
            hello = parse_viewer_message(await ViewerSocket(socket).receive())
        if not isinstance(hello, Hello):
            raise UserError(f"type: the first message must be hello, not {hello.type}")
        code, close = ErrorCode.LIMIT, POLICY
        service.settings.check_render(hello.size, hello.settings, service.settings.max_stream_pixels)
    except TimeoutError:
        await socket.close(BAD_PROTOCOL, f"no hello within {HELLO_SECONDS:.0f} s, or before too many others came")
    except UserError as error:
        await socket.send_text(Error(code=code, message=str(error)).model_dump_json())
        await socket.close(close, "the hello was refused")
    else:
        return hello
    return None
