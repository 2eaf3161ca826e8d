from errno import ENOSYS

import pytest

from server.scenes import landlock


def refuse(*_: object) -> int:
    raise OSError(ENOSYS, "Function not implemented")


def test_a_kernel_without_it_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(landlock, "system_call", refuse)
    assert landlock.version() == 0
    assert not landlock.restrict([])


def test_a_kernel_that_says_no_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(landlock, "version", lambda: 3)
    monkeypatch.setattr(landlock, "system_call", refuse)
    assert not landlock.restrict([])
