import os
import signal

import pytest

from tests.fuzz.apart import EndedError, FaultError, apart


def test_an_answer_comes_from_another_process() -> None:
    assert apart(os.getpid) != os.getpid()


def test_what_is_raised_has_its_place_and_traceback() -> None:
    with pytest.raises(FaultError) as caught:
        apart(lambda: 1 // 0)
    assert caught.value.place.startswith("ZeroDivisionError-test_apart-")
    assert caught.value.why.endswith("ZeroDivisionError: integer division or modulo by zero\n")


def test_a_process_may_be_ended() -> None:
    with pytest.raises(EndedError, match="SIGKILL"):
        apart(lambda: os.kill(os.getpid(), signal.SIGKILL))
