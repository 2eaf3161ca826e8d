import asyncio

import httpx
import pytest
from starlette.responses import JSONResponse
from starlette.types import Message, Receive, Scope, Send

from server.cluster.own_path import OwnPath, ToOwnPath


async def echo(scope: Scope, receive: Receive, send: Send) -> None:
    """Answers with what it sees of a request, in a view of memory."""

    async def as_view(message: Message) -> None:
        await send({**message, "body": memoryview(message["body"])} if "body" in message else message)

    await JSONResponse({"root": scope["root_path"], "path": scope["path"]})(scope, receive, as_view)


def ask(path: str, root: str = "") -> httpx.Response:
    async def get() -> httpx.Response:
        transport = httpx.ASGITransport(OwnPath(ToOwnPath(echo, "/r/one")), root_path=root)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
            return await http.get(path)

    return asyncio.run(get())


@pytest.mark.parametrize("root", ["", "/walk"])
@pytest.mark.parametrize("replica", ["one", "gone"])
def test_whatever_replica_is_named_is_the_prefix(root: str, replica: str) -> None:
    path = f"{root}/r/{replica}/api/v1/jobs"
    assert ask(path, root).json() == {"root": f"{root}/r/{replica}", "path": path}
    assert ask(f"{root}/r/{replica}/", root).json()["root"] == f"{root}/r/{replica}"


@pytest.mark.parametrize("root", ["", "/walk"])
def test_who_names_none_is_sent_to_this_one_for_the_page(root: str) -> None:
    assert ask(f"{root}/api/v1/jobs", root).json()["root"] == root
    answer = ask(f"{root}/", root)
    assert (answer.status_code, answer.headers["Location"]) == (307, f"{root}/r/one/")


def test_bodies_are_bytes() -> None:
    bodies = []

    async def keep(message: Message) -> None:
        bodies.extend([message["body"]] if "body" in message else [])

    async def receive() -> Message:
        return {"type": "http.disconnect"}

    scope = {"type": "http", "path": "/r/one/x", "root_path": "", "method": "GET", "headers": []}
    asyncio.run(OwnPath(echo)(scope, receive, keep))
    assert [type(it) for it in bodies] == [bytes]
