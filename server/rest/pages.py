"""The page in web/, as static files."""

import mimetypes
from pathlib import Path

from starlette.middleware.gzip import GZipMiddleware
from starlette.staticfiles import StaticFiles
from starlette.types import Receive, Scope, Send

from server.errors import error_response

FOLDER = Path(__file__).resolve().parents[2] / "web"
LEVEL = 6  # of compression: a fifth of a millisecond a file, for two thirds of its bytes

# Some systems' tables say otherwise, and browsers then refuse a module.
for _suffix, _type in ((".js", "text/javascript"), (".css", "text/css"), (".svg", "image/svg+xml")):
    mimetypes.add_type(_type, _suffix)


class Pages(StaticFiles):
    """Files that a browser keeps but asks about (ETag) each time, so that a new version is seen at once; compressed.

    What is asked for at no other place ends here.
    """

    def __init__(self) -> None:
        super().__init__(directory=FOLDER, html=True)
        self._compressed = GZipMiddleware(super().__call__, compresslevel=LEVEL)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a file, and refuse a WebSocket."""
        if scope["type"] == "websocket":
            await error_response(404, "not-found", "WebSockets are at /api/v1/stream")(scope, receive, send)
        else:
            await self._compressed(scope, receive, send)
