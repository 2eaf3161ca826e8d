import asyncio
import logging
import os
import re
import signal
import sys
import tempfile
from collections.abc import Awaitable, Callable
from pathlib import Path
from unittest.mock import create_autospec

import pytest
from harness import GRADIENT_WORKER, PATIENCE, rogue

from server.render.engine import Engine
from server.render.worker_link import WorkerLink, WorkerLostError
from server.render.worker_process import WorkerProcess
from server.render.workers import Workers
from server.wire.worker import Leave, Progress, Ready, SceneRef, Start, pack

START = Start(SceneRef("cornell-box", "cornell-box"))
STUBBORN = (sys.executable, "-c", "import time; time.sleep(3600)")


def linked(command: tuple[str, ...], scenario: Callable[[WorkerLink], Awaitable[None]]) -> int | None:
    """Runs a scenario with a worker; returns how that ended."""

    async def main() -> int | None:
        link = await WorkerLink.to(Workers(command, START).new())
        try:
            await scenario(link)
        finally:
            status = await link.stop()
        return status

    return asyncio.run(main())


async def read_on(link: WorkerLink) -> None:
    while True:
        await link.receive(lambda: 0)


def gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_a_worker_is_spoken_to_and_ends_by_itself() -> None:
    async def scenario(link: WorkerLink) -> None:
        kinds = [type((await link.receive(lambda: 0))[0])]
        while kinds[-1] is Progress:
            kinds.append(type((await link.receive(lambda: 0))[0]))
        assert len(kinds) > 1
        assert kinds[-1] is Ready

    assert linked(GRADIENT_WORKER, scenario) == 0


def test_what_is_sent_together_goes_in_one_writing() -> None:
    writer = create_autospec(asyncio.StreamWriter, instance=True)
    link = WorkerLink(create_autospec(WorkerProcess, instance=True), create_autospec(asyncio.StreamReader), writer)
    with link.together():
        link.send(Leave(1))
        link.send(Leave(2))
        assert not writer.write.called
    link.send(Leave(3))
    with link.together():
        pass
    assert [call.args[0] for call in writer.write.call_args_list] == [pack(Leave(1)) + pack(Leave(2)), pack(Leave(3))]


def test_a_worker_that_does_not_end_by_itself_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.worker_link.STOP_SECONDS", 0.2)

    async def scenario(link: WorkerLink) -> None:
        pass

    assert linked(STUBBORN, scenario) == -signal.SIGKILL


def test_no_worker_is_left_when_its_end_is_not_waited_for() -> None:
    async def main() -> int:
        link = await WorkerLink.to(WorkerProcess(STUBBORN))
        stopping = asyncio.create_task(link.stop())
        await asyncio.sleep(0.05)
        stopping.cancel()
        with pytest.raises(asyncio.CancelledError):
            await stopping
        return link.pid

    assert gone(asyncio.run(main()))  # not even its exit status is left


def test_a_worker_that_ended_is_lost() -> None:
    async def scenario(link: WorkerLink) -> None:
        with pytest.raises(WorkerLostError, match="ended"):
            await link.receive(lambda: 0)

    assert linked(rogue("early-death"), scenario) == 3


@pytest.mark.parametrize(
    ("way", "words"),
    [
        ("garbage", "not a message"),
        ("huge", "are too many"),
        ("flood", "words on its progress"),
        ("wrong-side", "leave, which is not for it to say"),
    ],
)
def test_a_worker_that_sends_what_it_should_not_is_killed(way: str, words: str) -> None:
    async def scenario(link: WorkerLink) -> None:
        with pytest.raises(WorkerLostError, match=words):
            await read_on(link)

    linked(rogue(way), scenario)


@pytest.mark.parametrize(
    ("way", "words"),
    [
        ("early-answer", "free out of turn"),
        ("ready-again", "ready out of turn"),
        ("wrong-answer", "opened out of turn"),
        ("other-size", "done out of turn"),
        ("large-image", "are too many"),
        ("answer-again", "done out of turn"),
    ],
)
def test_the_engine_starts_anew_after_answers_that_nobody_asked_for(
    way: str, words: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.ERROR)

    async def main() -> None:
        engine = Engine(START, rogue(way))
        task = asyncio.create_task(engine.run())
        async with asyncio.timeout(PATIENCE):
            while engine.restarts == 0:
                await asyncio.sleep(0.01)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(main())
    assert re.search(words, caplog.text)


def test_a_link_that_is_not_waited_for_leaves_no_worker_and_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        process = WorkerProcess(STUBBORN)
        starting = asyncio.create_task(WorkerLink.to(process))
        await asyncio.sleep(0)  # it waits for its own end of the socket now
        starting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await starting
        assert gone(process.pid)

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    asyncio.run(main())
    assert list(tmp_path.iterdir()) == []
