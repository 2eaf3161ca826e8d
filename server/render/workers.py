"""Starts the workers of an engine, the first of which may run before there is a loop."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from server.render.worker_process import WorkerProcess
from server.wire.worker import Start, pack


class Workers:
    """Starts one worker after another by a command, each of which is told the same."""

    def __init__(self, command: Sequence[str], start: Start) -> None:
        self._command, self.start = command, start
        self._early: WorkerProcess | None = None

    def new(self) -> WorkerProcess:
        """A worker, which is the early one if nobody has that; UserError when it cannot run."""
        early, self._early = self._early, None
        return early or self._told(WorkerProcess(self._command))

    @contextmanager
    def early(self, first: WorkerProcess | None = None) -> Iterator[None]:
        """Have the first worker run from now on, `first` if that does already; at the end of the context it ends."""
        with first or WorkerProcess(self._command) as worker:
            self._early = self._told(worker)
            yield

    def _told(self, worker: WorkerProcess) -> WorkerProcess:
        with suppress(OSError):  # it has ended, which who reads its messages hears
            worker.socket.sendall(pack(self.start))  # so little that nothing waits for the worker
        return worker
