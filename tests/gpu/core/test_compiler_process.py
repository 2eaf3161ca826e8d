import ctypes
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import gpu.core.compiler_process as compiler_process
from gpu.core.compiler_process import value_of

LIBC = "libc.so.6"


def is_running(pid: int) -> bool:
    """Whether there is such a process that has not ended."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_calls_are_answered_until_there_are_no_more_whatever_the_terminal_says() -> None:
    command = (sys.executable, "-I", "-S", compiler_process.__file__, str(os.getpid()))
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        for text in (b"five", b"fifteen"):
            process.stdin.write(pickle.dumps((LIBC, "strlen", ["c_char_p"], (text,))))
            process.stdin.flush()
            assert int(process.stdout.readline()) == len(text)
            process.send_signal(signal.SIGINT)
        process.stdin.write(pickle.dumps((LIBC, "puts", ["c_char_p"], (b"printed",))))
        process.stdin.flush()
        assert int(process.stdout.readline()) >= 0
        process.stdin.close()
        assert process.wait(30) == 0
        assert process.stderr.read() == b"printed\n"


def test_it_ends_in_the_midst_of_a_call_once_its_parent_is_gone() -> None:
    request = pickle.dumps((LIBC, "sleep", ["c_int"], (60,)))
    parent = f"""
import os, subprocess, sys
command = (sys.executable, "-I", "-S", {compiler_process.__file__!r}, str(os.getpid()))
process = subprocess.Popen(command, stdin=subprocess.PIPE)
process.stdin.write({request!r})
process.stdin.flush()
print(process.pid, flush=True)
sys.stdin.read()
"""
    with subprocess.Popen((sys.executable, "-c", parent), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        pid = int(process.stdout.readline())
        assert is_running(pid)
        process.kill()
    deadline = monotonic() + 20.0
    while is_running(pid):
        assert monotonic() < deadline
        sleep(0.05)


def test_arguments_are_as_native_functions_take_them() -> None:
    assert value_of("c_int", 3).value == 3
    assert value_of("c_bool", True).value is True
    assert value_of("c_char_p", None).value is None
    assert list(value_of("c_void_p", (b"one", b"two"))) == [b"one", b"two", None]
    assert isinstance(value_of("c_ulong", 1), ctypes.c_ulong)
