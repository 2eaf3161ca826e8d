import os
from errno import EBADF, EINVAL

import pytest

from server.scenes import kernel

CLOSE = {"x86_64": 3, "aarch64": 57}


def test_a_refusal_is_an_error() -> None:
    if kernel.machine() not in CLOSE:
        pytest.skip("another kind of machine")
    with pytest.raises(OSError, match=os.strerror(EBADF)):
        kernel.system_call(CLOSE[kernel.machine()], -1)
    with pytest.raises(OSError, match=os.strerror(EINVAL)):
        kernel.process_control(kernel.PR_SET_NO_NEW_PRIVS, 7)


def test_other_systems_have_no_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "darwin")
    assert kernel.machine() == ""
