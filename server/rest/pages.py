"""The page in web/: joined into a few answers (server.rest.joined), and as files."""

import mimetypes
from pathlib import Path

from starlette.datastructures import Headers
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import Response
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Receive, Scope, Send

from server.errors import error_response
from server.http.forwarded import route_path
from server.rest.joined import PLACE, Joined

FOLDER = Path(__file__).resolve().parents[2] / "web"
KEPT = "private, max-age=31536000, immutable"
LEVEL = 6  # of compression: a fifth of a millisecond a file, for two thirds of its bytes

# Some systems' tables say otherwise, and browsers then refuse a module.
for _suffix, _type in ((".js", "text/javascript"), (".css", "text/css"), (".svg", "image/svg+xml")):
    mimetypes.add_type(_type, _suffix)


class Pages(StaticFiles):
    """Files that a browser keeps but asks about (ETag) each time, so that a new version is seen at once; compressed.

    What is asked for at no other place ends here. What the page has joined is kept for good, by the digest in its
    address: that of another version, as while services are replaced, is this one's, and asked about.
    """

    def __init__(self) -> None:
        super().__init__(directory=FOLDER, html=True)
        self._joined = Joined(FOLDER)
        self._compressed = GZipMiddleware(super().__call__, compresslevel=LEVEL)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a file, and refuse a WebSocket."""
        if scope["type"] == "websocket":
            await error_response(404, "not-found", "WebSockets are at /api/v1/stream")(scope, receive, send)
        else:
            answer = self._of_joined(scope) if scope["method"] == "GET" else None
            await (answer or self._compressed)(scope, receive, send)

    def _of_joined(self, scope: Scope) -> Response | None:
        """The page, or what it has joined; None where something else is asked for."""
        match route_path(scope).split("/", 3):
            case ["", ("" | "index.html")]:
                self._joined.look()
                digest, name = "", "index.html"
            case ["", place, digest, name] if place == PLACE:
                pass
            case _:
                return None
        text = self._joined.text(name)
        if text is None:
            return None
        asked = Headers(scope=scope)
        packed = "gzip" in asked.get("Accept-Encoding", "")
        tag = f'"{self._joined.digest}{"-gzip" if packed else ""}"'
        headers = {"ETag": tag, "Vary": "Accept-Encoding"}
        if digest == self._joined.digest:
            headers["Cache-Control"] = KEPT
        if packed:
            headers["Content-Encoding"] = "gzip"
        media_type = mimetypes.guess_type(name)[0] or "application/json"  # a source map's
        answer = Response(text.packed if packed else text.plain, headers=headers, media_type=media_type)
        return NotModifiedResponse(answer.headers) if self.is_not_modified(answer.headers, asked) else answer
