"""Records the camera path of somebody who walks in a browser: a relay that reads the poses which pass by."""

from collections.abc import Callable
from time import perf_counter

from websockets.frames import Frame, Opcode
from websockets.http11 import Request
from websockets.server import ServerProtocol

from gpu.errors import UserError
from server.wire.browser import Pose, parse_viewer_message
from tests.load.paths import View

UPGRADE = b"GET /api/v1/stream"


class Recorder:
    """Views of one recording and their times [s]: those of the connection on which poses came first."""

    def __init__(self, now: Callable[[], float] = perf_counter) -> None:
        self.times: list[float] = []
        self.views: list[View] = []
        self._now = now
        self._heard: object | None = None

    def tap(self) -> Callable[[bytes], None]:
        """What hears the bytes of one connection, as `relay` wants it."""
        protocol = ServerProtocol(max_size=2**20)
        streams: bool | None = None

        def hear(data: bytes) -> None:
            nonlocal streams
            if streams is None:
                streams = data.startswith(UPGRADE)
            if not streams:  # the page's files
                return
            protocol.receive_data(data)
            for event in protocol.events_received():
                if isinstance(event, Frame):
                    if event.opcode is Opcode.TEXT:
                        self._take(protocol, bytes(event.data))
                elif isinstance(event, Request):  # which the service itself answers
                    protocol.send_response(protocol.accept(event))
            protocol.data_to_send()

        return hear

    def _take(self, connection: object, text: bytes) -> None:
        try:
            message = parse_viewer_message(text)
        except UserError:
            return  # the service will say so
        if isinstance(message, Pose) and self._heard in (None, connection):
            self._heard = connection
            self.times.append(self._now())
            self.views.append(View(message.matrix, message.yfov))
