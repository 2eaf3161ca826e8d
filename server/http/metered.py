"""What answering takes of the event loop, counted as it is taken, so that whoever asked for it is held to account."""

from collections.abc import Callable, Coroutine, Generator
from time import thread_time
from typing import Any, Generic, TypeVar

from starlette.types import ASGIApp, Receive, Scope, Send

from server.addresses import client_network
from server.http.connection import connection_of
from server.places import asker
from server.service import Service

Value = TypeVar("Value")

# Of a turn, that everybody may have: only those that let others wait for longer are counted.
FREE_SECONDS = 0.001
# Without and with the token: no turn takes longer for what somebody says, of which there is an end. The rest is the
# machine's own, as when garbage is collected, and would hold a connection back until it is taken for silent.
MOST_SECONDS, TRUSTED_MOST_SECONDS = 0.02, 0.1


class Metered(Generic[Value]):
    """Awaits a coroutine; charge(seconds) hears what each of its turns took of a core beyond what is free.

    Tasks that it starts are not counted.
    """

    def __init__(self, work: Coroutine[Any, Any, Value], charge: Callable[[float], None]) -> None:
        self._work = work
        self._charge = charge

    def __await__(self) -> Generator[Any, Any, Value]:
        """Pass on what the coroutine waits for, and what it gets."""
        steps, sent, error = self._work.__await__(), None, None
        while True:
            began = thread_time()
            try:
                awaited = steps.send(sent) if error is None else steps.throw(error)
            except StopIteration as end:
                value: Value = end.value
                return value
            finally:
                if (beyond := thread_time() - began - FREE_SECONDS) > 0.0:
                    self._charge(beyond)
            sent = error = None
            try:
                sent = yield awaited
            except BaseException as thrown:  # also when the task is cancelled, or closed
                error = thrown


class Meter:
    """ASGI middleware that notes for whom tasks work from here on, and counts what answering takes, but for that of
    the application's own tasks.
    """

    def __init__(self, app: ASGIApp, service: Service) -> None:
        self._app = app
        self._service = service

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        else:
            asker.set(client_of(scope))
            work: Any = self._app(scope, receive, send)
            await Metered(work, charger(scope, self._service))


def client_of(scope: Scope) -> str:
    """Who has sent a request or a handshake, as clients are counted."""
    return client_network((scope["client"] or ("",))[0])


def charger(scope: Scope, service: Service) -> Callable[[float], None]:
    """What hears of the seconds of a core that a request, or what is said over a WebSocket, has taken.

    Before a token was shown they are charged to all who have shown none, then to the client; of a WebSocket less is
    read, too.
    """
    connection, client = connection_of(scope), client_of(scope)

    def charge(seconds: float) -> None:
        trusted = connection is None or connection.trusted
        taken = min(seconds, TRUSTED_MOST_SECONDS if trusted else MOST_SECONDS)
        if trusted:
            service.efforts.take(client, 1e3 * taken)
        if connection is not None and not (trusted and scope["type"] == "http"):
            connection.charge(taken)

    return charge
