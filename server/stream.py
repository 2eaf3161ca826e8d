"""The WebSocket endpoint: admits a viewer and reads its messages. server.protocol describes the wire."""

import asyncio

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from gpu.errors import UserError
from server.protocol import Error, ErrorCode, Hello, parse_viewer_message
from server.service import Service, TheService
from server.viewer import Viewer, receive

HELLO_SECONDS = 10.0
BAD_PROTOCOL, POLICY, TRY_AGAIN = 1002, 1008, 1013

router = APIRouter()


@router.websocket("/api/v1/stream")
async def stream(socket: WebSocket, service: TheService) -> None:
    """Serve one viewer until it leaves."""
    await socket.accept()
    number = service.admit()
    if number is None:
        await socket.close(TRY_AGAIN, f"{service.settings.max_viewers} viewers are here already; try again later")
        return
    try:
        hello = await _greet(socket, service)
        if hello is not None:
            await Viewer(socket, service, number, hello).run()
    except WebSocketDisconnect:
        pass
    finally:
        service.dismiss(number)


async def _greet(socket: WebSocket, service: Service) -> Hello | None:
    """The viewer's hello; None when there is none that can be served, and then the socket is closed."""
    code, close = ErrorCode.BAD_MESSAGE, BAD_PROTOCOL
    try:
        async with asyncio.timeout(HELLO_SECONDS):
            hello = parse_viewer_message(await receive(socket))
        if not isinstance(hello, Hello):
            raise UserError(f"type: the first message must be hello, not {hello.type}")
        code, close = ErrorCode.LIMIT, POLICY
        service.settings.check_render(hello.size, hello.settings, service.settings.max_stream_pixels)
    except TimeoutError:
        await socket.close(BAD_PROTOCOL, f"no hello within {HELLO_SECONDS:.0f} s")
    except UserError as error:
        await socket.send_text(Error(code=code, message=str(error)).model_dump_json())
        await socket.close(close, "the hello was refused")
    else:
        return hello
    return None
