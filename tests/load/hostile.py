"""Clients that read slowly or not at all, send too much, come in numbers or have no business here."""

import asyncio
import json
from contextlib import AsyncExitStack, suppress
from time import perf_counter
from typing import Any

import numpy as np
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException

from server.wire.browser import PROTOCOL
from tests.load import probe
from tests.load.checks import START_SECONDS, Outcome, Scale, crowd_of, goes_on
from tests.load.crowd import ARRIVAL_SECONDS, wait_for, walking
from tests.load.relay import relay
from tests.load.target import Socket, Target
from tests.load.viewer import Plan, Viewer

TOO_BIG = 17 * 2**20  # bytes
FLOOD_RATE, FLOOD_BYTES = 10_000, 4000  # messages a second; of one, so that buffers do not hide what is not read
THIN_RATE, AT_ONCE = 1000.0, 32_768  # bytes a second; bytes that come at once before, for the first words
STALLED_SECONDS = 30.0
POLICY, TOO_LARGE, COME_AGAIN = 1008, 1009, 1013


async def slow_reader(target: Target, scale: Scale) -> Outcome:
    """One of eight reads 1 KB/s: the others must hardly notice, compared with when it reads as they do."""
    outcome = Outcome()
    p99: dict[str, list[float]] = {"fast": [], "slow": []}
    fps: dict[str, list[float]] = {"fast": [], "slow": []}
    async with crowd_of(target, scale, 7) as others, relay(target.address, rate=THIN_RATE, at_once=AT_ONCE) as thin:
        for _ in range(scale.phases):
            for name, url in (("fast", None), ("slow", thin)):
                eighth = asyncio.create_task(_return(target, Plan(scale.size, seed=7), url))
                await asyncio.sleep(0.2 * scale.phase_seconds)
                since = perf_counter()
                await asyncio.sleep(scale.phase_seconds)
                ages = [
                    one.arrived
                    for viewer in others
                    for one in viewer.log.seen
                    if one.at > since and one.arrived is not None
                ]
                p99[name].append(float(np.percentile(ages, 99)) if ages else np.inf)
                fps[name].append(len(ages) / len(others) / scale.phase_seconds)
                eighth.cancel()
                await asyncio.wait([eighth])
        outcome.still_there(others)
    fast, slow = sorted(p99["fast"])[scale.phases // 2], sorted(p99["slow"])[scale.phases // 2]
    change = slow / fast - 1.0 if fast < np.inf else np.inf
    outcome.measured = {"p99_ms": p99, "fps": fps, "change": change}
    outcome.expect(change <= scale.change, f"the others' p99 age moved by {100 * change:.0f} %")
    outcome.expect(
        min(fps["slow"]) > 0.5 * min(fps["fast"]), f"the others got {fps['slow']} frames a second of {fps['fast']}"
    )
    return outcome


async def stalled_readers(target: Target, scale: Scale) -> Outcome:
    """One who acknowledges nothing and one who does not even read: both are dropped, and nobody else."""
    outcome = Outcome()
    async with crowd_of(target, scale, 1) as others, target.http() as http, AsyncExitStack() as stack:
        mute = await stack.enter_async_context(walking(target, Plan(scale.size, seed=1, acknowledge=False)))
        await wait_for(lambda: bool(mute.log.seen), START_SECONDS)
        deaf = await stack.enter_async_context(target.socket())
        await _stop_reading(deaf, scale)
        began, dropped = perf_counter(), None
        while dropped is None and perf_counter() - began < STALLED_SECONDS:
            await asyncio.sleep(0.1)
            if (await probe.state(http))["viewers"] <= len(others):
                dropped = perf_counter() - began
        outcome.expect(dropped is not None, f"not both were dropped within {STALLED_SECONDS:.0f} s")
        # The server forgets a viewer before that one has read why.
        await wait_for(lambda: mute.log.closed is not None, STALLED_SECONDS)
        code = mute.log.closed[0] if mute.log.closed else None
        outcome.expect(code == COME_AGAIN, f"closed with {code}, not {COME_AGAIN}")
        outcome.still_there(others)
        deaf.transport.abort()
    outcome.measured = {"seconds": dropped, "close": mute.log.closed}
    return outcome


async def too_many(target: Target, scale: Scale) -> Outcome:
    """Twice as many as are let in come in a row: the second half of them is turned away at once."""
    outcome = Outcome()
    async with AsyncExitStack() as stack:
        knocks = []
        for _ in range(2 * scale.viewers):
            knocks.append(asyncio.create_task(_knock(target, stack)))
            await asyncio.sleep(ARRIVAL_SECONDS)
        answers = await asyncio.gather(*knocks)
    refused = [ms for welcome, ms in answers if not welcome]
    outcome.measured = {
        "let_in": len(answers) - len(refused),
        "refused": len(refused),
        "worst_ms": max(refused, default=0),
    }
    outcome.expect(len(refused) == scale.viewers, f"{len(refused)} of {len(answers)} were refused, not {scale.viewers}")
    outcome.expect(max(refused, default=0) <= scale.refused_ms, f"a refusal took {max(refused, default=0):.0f} ms")
    return outcome


async def oversized(target: Target, scale: Scale) -> Outcome:
    """A message of 17 MiB is closed with 1009."""
    outcome = Outcome()
    async with crowd_of(target, scale, 1) as others, target.socket() as socket:
        with suppress(ConnectionClosed):
            await socket.send("x" * TOO_BIG)
            await asyncio.wait_for(_drain(socket), 10.0)
        outcome.measured = {"close": socket.close_code}
        outcome.expect(socket.close_code == TOO_LARGE, f"closed with {socket.close_code}, not {TOO_LARGE}")
        await goes_on(others, outcome)
    return outcome


async def flood(target: Target, scale: Scale) -> Outcome:
    """10 000 messages a second from one: it is slowed down or closed by policy, and the others walk on."""
    outcome = Outcome()
    async with crowd_of(target, scale, 2) as others:
        before = await _rate(others, scale.flood_seconds)
        async with target.socket() as socket:
            reading = asyncio.create_task(_drain(socket))
            flooding = asyncio.create_task(_send_many(socket, scale))
            during = await _rate(others, scale.flood_seconds)
            sent, seconds = await flooding
            held_back = socket.transport.get_write_buffer_size() > 0
            reading.cancel()
            await asyncio.wait([reading])
            code = socket.close_code
            socket.transport.abort()
        outcome.still_there(others)
    outcome.measured = {"sent": sent, "a_second": sent / seconds, "close": code, "fps": [before, during]}
    slowed = held_back and sent / seconds < 0.5 * FLOOD_RATE
    outcome.expect(code == POLICY or slowed, f"{sent / seconds:.0f} messages a second were taken, close code {code}")
    outcome.expect(during > 0.5 * before, f"the others got {during:.1f} frames a second of {before:.1f}")
    return outcome


async def strangers(target: Target, scale: Scale) -> Outcome:
    """Pages of another origin get 403, programs without the token or with a wrong one 401, before any upgrade."""
    outcome = Outcome()
    wanted: dict[str, tuple[dict[str, Any], int]] = {
        "foreign origin": ({"origin": "https://example.org"}, 403),
        "no token": ({"additional_headers": {}}, 401),
        "wrong token": ({"additional_headers": {"Authorization": "Bearer " + 32 * "x"}}, 401),
    }
    for name, (options, status) in wanted.items():
        got: Any = "let in"
        try:
            async with target.socket(**options):
                pass
        except InvalidStatus as error:
            got = error.response.status_code
        outcome.measured[name] = got
        outcome.expect(got == status, f"{name}: {got}, not {status}")
    return outcome


async def _return(target: Target, plan: Plan, url: str | None) -> None:
    """A viewer who comes back whenever it is closed."""
    while True:
        with suppress(OSError, TimeoutError, WebSocketException):
            async with walking(target, plan, url) as viewer:
                await wait_for(lambda log=viewer.log: log.closed is not None, 3600.0)  # type: ignore[misc]
        await asyncio.sleep(0.2)


async def _stop_reading(socket: Socket, scale: Scale) -> None:
    """Say hello, walk a few steps, and read nothing from then on."""
    await socket.send(json.dumps({"type": "hello", "protocol": PROTOCOL, "size": scale.size}))
    while json.loads(await socket.recv())["type"] != "scene":
        pass
    socket.transport.pause_reading()
    for number in range(1, 20):
        await socket.send(_pose(number))
        await asyncio.sleep(0.02)


async def _knock(target: Target, stack: AsyncExitStack) -> tuple[bool, float]:
    """Whether one is let in, and the milliseconds until that was known. It stays until the stack ends."""
    began = perf_counter()
    try:
        socket = await stack.enter_async_context(target.socket())
        await socket.send(json.dumps({"type": "hello", "protocol": PROTOCOL, "size": [64, 36]}))
        welcome = json.loads(await socket.recv())["type"] == "welcome"
    except (InvalidStatus, ConnectionClosed):
        welcome = False
    return welcome, 1e3 * (perf_counter() - began)


async def _send_many(socket: Socket, scale: Scale) -> tuple[int, float]:
    """Poses at the rate of a flood: how many went out, in how many seconds."""
    pose = _pose(1).ljust(FLOOD_BYTES)  # made once: what makes the flood must not be what slows it down
    began, sent = perf_counter(), 0
    with suppress(ConnectionClosed, TimeoutError):
        async with asyncio.timeout(scale.flood_seconds):
            await socket.send(json.dumps({"type": "hello", "protocol": PROTOCOL, "size": scale.size}))
            while True:
                due = int((perf_counter() - began) * FLOOD_RATE)
                for _ in range(due - sent):
                    sent += 1
                    await socket.send(pose)
                await asyncio.sleep(0.001)
    return sent, perf_counter() - began


def _pose(number: int) -> str:
    matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.001 * number, 0.0, 0.0, 1.0]
    return json.dumps({"type": "pose", "id": number, "matrix": matrix, "yfov": 1.0})


async def _drain(socket: Socket) -> None:
    """Read until it is closed."""
    with suppress(ConnectionClosed):
        while True:
            await socket.recv()


async def _rate(viewers: list[Viewer], seconds: float) -> float:
    """Frames a second and viewer in the next seconds."""
    before = sum(len(viewer.log.seen) for viewer in viewers)
    await asyncio.sleep(seconds)
    return (sum(len(viewer.log.seen) for viewer in viewers) - before) / seconds / len(viewers)
