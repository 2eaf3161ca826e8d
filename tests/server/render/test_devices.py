import sys

import pytest

from gpu.errors import UserError
from server.render import devices
from server.render.devices import chosen_devices


def test_names_are_devices_a_worker_each() -> None:
    assert chosen_devices(None) == (None,)
    assert chosen_devices("cuda:1") == ("cuda:1",)
    assert chosen_devices("cuda:0, cuda:1") == ("cuda:0", "cuda:1")
    assert chosen_devices("cpu,cpu") == ("cpu", "cpu")


@pytest.mark.parametrize("device", ["cuda:0,", "", ",", "cpu,all"])
def test_what_names_no_devices_is_said(device: str) -> None:
    with pytest.raises(UserError, match="device: "):
        chosen_devices(device)


def test_all_are_those_that_the_machine_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "LIST", (sys.executable, "-c", "print('cuda:0\\ncuda:1')"))
    assert chosen_devices("all") == ("cuda:0", "cuda:1")


def test_devices_that_cannot_be_listed_are_to_be_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "LIST", (sys.executable, "-c", "raise SystemExit(3)"))
    with pytest.raises(UserError, match="name them instead"):
        chosen_devices("all")
