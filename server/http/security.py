"""Who may use the service. Host, Origin and token are judged before anything else sees a request or a handshake.

Host: a page elsewhere whose name is made to point here (DNS rebinding) calls this service by that page's name. On a
loopback address only loopback names are answered to, elsewhere any; `allowed_hosts` adds names, or limits to them.
Origin: browsers say which page opens a WebSocket or sends a form; it must be one of ours (scheme, host and port) or of
`allowed_origins`.
Token: `?token=` on a page becomes a cookie and goes from the address; programs send `Authorization: Bearer`. Pages of
other sites have no cookie, and cannot give a WebSocket headers: they offer the token as a subprotocol.
"""

import binascii
import hmac
import secrets
from base64 import urlsafe_b64decode
from hashlib import sha256
from urllib.parse import parse_qsl, quote, urlencode

from pydantic import SecretStr
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from server.addresses import client_network, host_of, is_loopback, origin_of
from server.errors import error_response
from server.http.connection import connection_of
from server.http.cors import is_preflight
from server.http.forwarded import route_path
from server.metrics import Metrics
from server.rate_limit import Buckets
from server.settings import ServerSettings

OPEN = ("/healthz", "/readyz")  # for supervisors, which have no token; they say little
SAFE = ("GET", "HEAD", "OPTIONS")
TOKEN_PROTOCOL = "bearer."  # and the token in base64url without padding, as subprotocols have few characters
WRONG_RATE, WRONG_BURST = 0.5, 20.0  # wrong tokens of one address: a second, and at once

CONTENT = {
    "default-src": "'none'",
    "script-src": "'self'",
    "style-src": "'self'",
    "img-src": "'self' blob: data:",
    "media-src": "'self' blob:",
    "font-src": "'self'",
    "connect-src": "'self'",
    "worker-src": "'self' blob:",
    "manifest-src": "'self'",
    "base-uri": "'none'",
    "form-action": "'self'",
    "frame-ancestors": "'none'",
}
FEATURES = ("accelerometer", "camera", "geolocation", "gyroscope", "magnetometer", "microphone", "payment", "usb")
HEADERS = {
    "Content-Security-Policy": "; ".join(f"{kind} {sources}" for kind, sources in CONTENT.items()),
    "Cross-Origin-Embedder-Policy": "require-corp",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": ", ".join([*(f"{name}=()" for name in FEATURES), "fullscreen=(self)", "gamepad=(self)"]),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}

# A cookie that is SameSite=Strict does not come along when a link on another site is followed; loading the page once
# more, from itself, brings it.
LOGIN = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">{again}<link rel="icon" href="data:,"><title>lumenwalk</title></head>
<body><h1>lumenwalk</h1>{wrong}<p>This service needs its token: open the address that it printed when it started, or</p>
<form><label>token <input name="token" type="password" required autofocus></label> <button>enter</button></form>
</body></html>
"""
AGAIN = '<meta http-equiv="refresh" content="0">'
WRONG = '<p role="alert">That is not the token.</p>'


def with_token(settings: ServerSettings) -> ServerSettings:
    """Settings with a new token where others could come and none is given; on a loopback address none is needed."""
    if settings.token is not None or is_loopback(settings.host):
        return settings
    return settings.model_copy(update={"token": SecretStr(secrets.token_urlsafe())})


class Key:
    """The token, and the cookie that browsers hold in its place: named after it, as ports do not tell cookies apart."""

    def __init__(self, token: str) -> None:
        self._token = token.encode()
        digest = hmac.new(self._token, b"lumenwalk cookie", sha256).hexdigest()
        self.cookie, self._value = f"lumenwalk-{digest[:8]}", digest[8:]

    def fits(self, token: str) -> bool:
        """Whether this is the token, in a time that does not depend on it."""
        return hmac.compare_digest(token.encode(errors="replace"), self._token)

    def fits_cookie(self, value: str) -> bool:
        """Whether this is the cookie's value, likewise."""
        return hmac.compare_digest(value.encode(errors="replace"), self._value.encode())

    def give(self, response: Response, path: str, secure: bool) -> None:
        """Let the browser keep the cookie for what is below `path`; `secure`: only for HTTPS."""
        response.set_cookie(self.cookie, self._value, path=path, secure=secure, httponly=True, samesite="strict")


class Guard:
    """ASGI middleware that answers 400, 401, 403 or 429 to those who may not come in."""

    def __init__(self, app: ASGIApp, settings: ServerSettings, metrics: Metrics) -> None:
        self._app = app
        self._key = Key(settings.token.get_secret_value()) if settings.token else None
        self._metrics = metrics
        self._any_host = not is_loopback(settings.host) and not settings.allowed_hosts
        self._hosts = settings.allowed_hosts
        self._origins = settings.allowed_origins
        self._wrong = Buckets(WRONG_RATE, WRONG_BURST)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what may come in."""
        judged = scope["type"] in ("http", "websocket") and route_path(scope) not in OPEN
        answer = self._judge(scope) if judged else None
        if judged and answer is None and (connection := connection_of(scope)) is not None:
            connection.trust()
        await (answer or self._app)(scope, receive, send)

    def _judge(self, scope: Scope) -> Response | None:
        """The answer to who may not come in, or who has brought the token in the address; else None."""
        headers = Headers(scope=scope)
        host = headers.get("Host", "")
        if not self._knows(host):
            self._metrics.refused("host")
            return error_response(400, "unknown-host", f"this service is not called {host!r}; see `allowed_hosts`")
        if scope["path"].endswith("\n"):  # which routes overlook there, but not whoever else goes by paths
            return error_response(404, "not-found", "no path ends in a line break")
        origin = headers.get("Origin", "")
        safe = scope["type"] == "http" and scope["method"] in SAFE and not is_preflight(scope["method"], headers)
        own = origin_of(f"{scope['scheme'].replace('ws', 'http')}://{host}")
        if origin and not safe and origin_of(origin) not in (own, *self._origins):
            self._metrics.refused("origin")
            text = f"not from a page of {origin!r}: this service is {own}, as far as it and its proxies know; "
            return error_response(403, "foreign-origin", text + "see `allowed_origins` and `trusted_proxies`")
        if _from_page_elsewhere(headers) and origin_of(origin) not in self._origins:
            self._metrics.refused("origin")
            return error_response(403, "foreign-origin", "asked for by a page of another site; see `allowed_origins`")
        return self._ask(scope, headers, self._key) if self._key is not None else None

    def _knows(self, host: str) -> bool:
        name = host_of(host)
        return name is not None and (self._any_host or is_loopback(name) or name in self._hosts)

    def _ask(self, scope: Scope, headers: Headers, key: Key) -> Response | None:
        """None for who has the token."""
        query = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        asked = [value for name, value in query if name == "token"] if scope["type"] == "http" else []
        bearer = _bearer(scope, headers)
        cookie = HTTPConnection(scope).cookies.get(key.cookie, "")
        brought = bool(asked or cookie) or bearer is not None
        address = client_network((scope["client"] or ("",))[0])
        if asked and key.fits(asked[-1]) and scope["method"] in SAFE:
            rest = urlencode([(name, value) for name, value in query if name != "token"])
            # From the same folder: so it leads back whatever prefix a proxy has taken away without a word.
            path = "./" + quote(scope["path"].rpartition("/")[2])
            response: Response = RedirectResponse(f"{path}?{rest}" if rest else path, 303)
            key.give(response, f"{scope['root_path']}/", secure=scope["scheme"] == "https")
            return response
        if key.fits_cookie(cookie) or (bearer is not None and key.fits(bearer)):
            return None
        # Who has the token is let in whatever others of the address have tried: they may share it, or have made it up.
        if brought and self._wrong.empty(address):
            self._metrics.refused("guesses")
            return error_response(429, "too-many-guesses", "too many wrong tokens from this address")
        if brought:
            self._wrong.take(address)
        self._metrics.refused("token")
        if scope["type"] == "http" and scope["method"] in SAFE and "text/html" in headers.get("Accept", ""):
            again = AGAIN if _from_elsewhere(headers) else ""
            response = HTMLResponse(LOGIN.format(again=again, wrong=WRONG if any(asked) else ""), 401)
        else:
            response = error_response(401, "unauthorized", "the token is missing or wrong: Authorization: Bearer TOKEN")
        response.headers["WWW-Authenticate"] = 'Bearer realm="lumenwalk"'
        return response


def _bearer(scope: Scope, headers: Headers) -> str | None:
    """A token in the header Authorization, or in a WebSocket's subprotocol; None when there is none."""
    scheme, _, token = headers.get("Authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        return token.strip()
    for offered in scope.get("subprotocols", ()):
        if offered.startswith(TOKEN_PROTOCOL):
            text = offered.removeprefix(TOKEN_PROTOCOL)
            try:
                return urlsafe_b64decode(text + "=" * (-len(text) % 4)).decode(errors="replace")
            except binascii.Error:
                return ""
    return None


def _from_page_elsewhere(headers: Headers) -> bool:
    """Whether a page of another site, and no user who follows a link, asks: it may not read it, but it costs."""
    return headers.get("Sec-Fetch-Site") == "cross-site" and headers.get("Sec-Fetch-Mode") != "navigate"


def _from_elsewhere(headers: Headers) -> bool:
    return headers.get("Sec-Fetch-Site") == "cross-site" and headers.get("Sec-Fetch-Mode") == "navigate"
