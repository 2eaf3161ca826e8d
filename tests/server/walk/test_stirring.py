"""A task that waits for a condition is woken once: when it holds."""

import asyncio

from harness import PATIENCE

from server.walk.stirring import Stirring


def test_who_waits_has_no_turn_before_the_condition_holds() -> None:
    looks, holds = 0, False
    turns: list[int] = []

    def condition() -> bool:
        nonlocal looks
        looks += 1
        return holds

    async def scenario() -> None:
        nonlocal holds
        stirring = Stirring(lambda: 0.0)

        async def wait() -> None:
            await stirring.until(condition)
            turns.append(looks)

        task = asyncio.create_task(wait())
        await asyncio.sleep(0)
        for _ in range(3):
            stirring.stir()
            await asyncio.sleep(0)
        assert (looks, turns) == (4, [])
        holds = True
        stirring.stir()
        await task
        assert len(turns) == 1

    asyncio.run(scenario())


def test_what_is_so_no_more_when_the_task_has_its_turn_is_waited_for_again() -> None:
    holds = True

    async def scenario() -> None:
        nonlocal holds
        stirring = Stirring(lambda: 0.0)
        holds = False
        task = asyncio.create_task(stirring.until(lambda: holds))
        await asyncio.sleep(0)
        holds = True
        stirring.stir()
        holds = False
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert not task.done()
        holds = True
        stirring.stir()
        await task

    asyncio.run(scenario())


def test_what_time_alone_changes_is_seen_though_it_moves() -> None:
    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        rests_at = loop.time() + 0.01
        stirring = Stirring(lambda: max(rests_at - loop.time(), 0.0))
        task = asyncio.create_task(stirring.until(lambda: loop.time() >= rests_at))
        await asyncio.sleep(0)
        rests_at += 0.03  # nothing stirs
        await asyncio.wait_for(task, PATIENCE)
        assert loop.time() >= rests_at

    asyncio.run(scenario())


def test_time_counts_from_when_something_stirs() -> None:
    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        rests_at: float | None = None
        stirring = Stirring(lambda: 0.0 if rests_at is None else max(rests_at - loop.time(), 0.0))
        task = asyncio.create_task(stirring.until(lambda: rests_at is not None and loop.time() >= rests_at))
        await asyncio.sleep(0)
        rests_at = loop.time() + 0.01
        stirring.stir()
        await asyncio.wait_for(task, PATIENCE)

    asyncio.run(scenario())
