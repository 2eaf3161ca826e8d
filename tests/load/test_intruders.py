import asyncio
import sys

import pytest

from tests.load import intruders


def test_only_services_of_this_machine_are_met(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["intruders", "192.0.2.1", "80", "1", "0", "0", "0"])
    assert intruders.main() == 2
    assert "this machine" in capsys.readouterr().err


def test_connections_that_end_are_made_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(intruders, "AGAIN_SECONDS", 0.0)

    async def run() -> None:
        heard: asyncio.Queue[bytes] = asyncio.Queue()

        async def meet(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            if len(heads) < 1:
                heads.append(await reader.read(65536))
            writer.close()
            heard.put_nowait(b"")

        heads: list[bytes] = []
        async with await asyncio.start_server(meet, "127.0.0.1", 0) as server:
            _, port = server.sockets[0].getsockname()
            running = asyncio.create_task(intruders.again(intruders.chunks, "127.0.0.1", port, 0.0))
            for _ in range(3):
                await heard.get()
            running.cancel()
            await asyncio.wait([running])
        assert heads[0].startswith(intruders.HEAD)

    asyncio.run(asyncio.wait_for(run(), 10.0))
