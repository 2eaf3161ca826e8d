"""The command `lumenwalk`: serve, render, compare, info, warm (server.cli.commands).

Exit status: 0 done; 1 `compare` met non-finite pixels; 2 a mistake in what was asked for, said in one line on stderr;
130 interrupted; ended by SIGTERM, it says so. Of a service that starts, the worker takes longest: it begins before
anything else is imported.
"""

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from gpu.errors import UserError
from server.render.worker_process import WORKER, WorkerProcess

HELP = {"-h", "--help"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command (of the process by default) and return its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        if given[:1] == ["serve"] and not HELP & {*given}:
            with _unwound_by_sigterm(), WorkerProcess(WORKER) as worker:
                status = _run(given, worker)
        else:
            status = _run(given)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has seen enough, as `head` does; Python's own flush at exit must not fail too
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except UserError as error:
        print(f"lumenwalk: error: {error}", file=sys.stderr)
        return 2
    except OSError as error:  # what the system does not give, such as a name that is too long for it
        print(f"lumenwalk: error: {error.filename or 'the system'}: {error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return status


class _Terminated(BaseException):
    pass


@contextmanager
def _unwound_by_sigterm() -> Iterator[None]:
    """SIGTERM gives back what is held within, the worker and its folder, before it ends this process; a second, not."""

    def stop(*_: object) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        raise _Terminated

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    except _Terminated:
        signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)


def _run(arguments: Sequence[str], worker: WorkerProcess | None = None) -> int:
    from server.cli.commands import run

    return run(arguments, worker)
