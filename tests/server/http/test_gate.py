import asyncio

import pytest
from harness import PATIENCE

from server.http import gate as module
from server.http.gate import Gate


class Client:
    """Somebody who waits, and takes `cost` of a core when it is let in."""

    def __init__(self, gate: Gate, order: list["Client"], cost: float = 0.0) -> None:
        self._gate, self._order, self._cost = gate, order, cost

    def proceed(self) -> None:
        self._order.append(self)
        self._gate.charge(self._cost)


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_share_of_a_core_and_a_little_at_once() -> None:
    clock = Clock()
    gate = Gate(now=clock)
    gate.charge(module.AT_ONCE / 2)
    assert gate.is_open
    gate.charge(module.AT_ONCE / 2 + 0.02)
    assert not gate.is_open
    clock.now = 0.99 * 0.02 / module.SHARE
    assert not gate.is_open
    clock.now = 1.01 * 0.02 / module.SHARE
    assert gate.is_open


def test_who_came_last_and_who_came_first_go_by_turns_and_who_left_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PAUSE_SECONDS", 0.0)

    async def run() -> None:
        gate = Gate()
        order: list[Client] = []
        clients = [Client(gate, order) for _ in range(4)]
        gate.charge(module.AT_ONCE + 1e-6)
        for client in clients:
            gate.wait(client)
        gate.leave(clients[2])
        while len(order) < 3:
            await asyncio.sleep(0)
        assert order == [clients[3], clients[0], clients[1]]

    asyncio.run(run())


def test_one_who_costs_much_shuts_it_for_the_others() -> None:
    async def run() -> None:
        gate = Gate()
        order: list[Client] = []
        gate.charge(module.AT_ONCE + 1e-6)
        for _ in range(2):
            gate.wait(Client(gate, order, cost=60.0))
        await gate.opened()
        await asyncio.sleep(0)
        while not order:
            await asyncio.sleep(0)
        assert len(order) == 1
        assert not gate.is_open

    asyncio.run(asyncio.wait_for(run(), PATIENCE))


def test_one_who_fails_does_not_shut_it_for_ever() -> None:
    class Failing(Client):
        def proceed(self) -> None:
            raise OSError

    async def run() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)
        gate = Gate()
        order: list[Client] = []
        gate.charge(module.AT_ONCE + 1e-6)
        gate.wait(Client(gate, order))
        gate.wait(Failing(gate, order))
        while not order:
            await asyncio.sleep(0)

    asyncio.run(asyncio.wait_for(run(), PATIENCE))
