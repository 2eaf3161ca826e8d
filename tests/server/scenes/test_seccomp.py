from errno import ENOSYS, EPERM

import pytest

from server.scenes import seccomp

OWN = 4711
X86, NUMBERS = 0xC000003E, {"read": 0, "socket": 41, "clone": 56, "execve": 59, "kill": 62, "ptrace": 101}
LATER = {"prlimit64": 302, "io_uring_setup": 425, "clone3": 435}
SIGCHLD, PTHREAD, NEW_USER = 17, 0x3D0F00, 0x10000000


def judge(lines: list[seccomp.Instruction], name: str, argument: int = 0, machine: int = X86) -> int:
    """Run a filter on a call as the kernel does; the error that the caller gets, 0 when it may go on."""
    known = {0: (NUMBERS | LATER)[name], 4: machine, 16: argument}
    at = value = 0
    while True:
        code, yes, no, number = lines[at]
        at += 1
        match code:
            case 0x20:
                value = known[number]
            case 0x06:
                return 0 if number == 0x7FFF0000 else number & 0xFFFF
            case 0x15:
                at += yes if value == number else no
            case 0x35:
                at += yes if value >= number else no
            case 0x45:
                at += yes if value & number else no


@pytest.mark.parametrize(
    ("name", "argument", "threads_only", "processes_too"),
    [
        ("read", 0, 0, 0),
        ("socket", 2, EPERM, EPERM),
        ("ptrace", 0, EPERM, EPERM),
        ("io_uring_setup", 0, EPERM, EPERM),
        ("execve", 0, EPERM, 0),
        ("clone", PTHREAD, 0, 0),
        ("clone", SIGCHLD, EPERM, 0),
        ("clone", SIGCHLD | NEW_USER, EPERM, EPERM),
        ("clone3", 0, ENOSYS, ENOSYS),
        ("kill", OWN, 0, 0),
        ("kill", OWN + 1, EPERM, EPERM),
        ("prlimit64", 0, 0, 0),
        ("prlimit64", OWN + 1, EPERM, EPERM),
    ],
)
def test_a_process_computes_and_nothing_else(name: str, argument: int, threads_only: int, processes_too: int) -> None:
    strict = seccomp.program("x86_64", OWN, starts_processes=False)
    lax = seccomp.program("x86_64", OWN, starts_processes=True)
    assert (judge(strict, name, argument), judge(lax, name, argument)) == (threads_only, processes_too)


def test_calls_of_another_kind_of_machine_are_refused() -> None:
    assert judge(seccomp.program("x86_64", OWN, starts_processes=True), "read", machine=0x40000003) == EPERM


def test_every_kind_of_machine_has_a_whole_filter() -> None:
    for kind in ("x86_64", "aarch64"):
        assert seccomp.program(kind, OWN, starts_processes=False)[-1] == (0x06, 0, 0, 0x7FFF0000)


def test_where_it_cannot_be_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seccomp, "machine", lambda: "riscv64")
    assert not seccomp.available()
    assert not seccomp.restrict(starts_processes=False)
