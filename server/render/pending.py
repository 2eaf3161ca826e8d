"""A job that the worker has and has not answered yet."""

import asyncio
from dataclasses import dataclass

from gpu.errors import OutOfMemoryError, UserError
from server.wire.worker import (
    MAX_EXPORT_BYTES,
    Cause,
    Closed,
    CloseScene,
    Done,
    Export,
    Exported,
    Job,
    Opened,
    OpenScene,
    Pick,
    Picked,
    Render,
)

Answer = Done | Opened | Closed | Picked | Exported
Reply = tuple[Answer, bytes]

# An image takes no more than that: 4 floats a pixel, and a header.
PIXEL_BYTES, HEADER_BYTES = 16, 2**16


class RenderFaultError(Exception):
    """A job failed by the program's fault."""


ERRORS: dict[Cause, type[Exception]] = {
    Cause.USER: UserError,
    Cause.MEMORY: OutOfMemoryError,
    Cause.PROGRAM: RenderFaultError,
}


@dataclass(frozen=True)
class PendingJob:
    """A job and the future of its reply, which may be cancelled when whoever asked has left."""

    job: Job
    reply: "asyncio.Future[Reply]"

    @property
    def most_bytes(self) -> int:
        """Of the answer's image or file."""
        if isinstance(self.job, Export):
            return MAX_EXPORT_BYTES
        if not isinstance(self.job, Render):
            return 0
        width, height = self.job.size
        return PIXEL_BYTES * width * height + HEADER_BYTES

    def answered_by(self, answer: Answer) -> bool:
        """Whether an answer is of the kind that the job asks for."""
        match self.job:
            case Render():
                return isinstance(answer, Done) and answer.size == self.job.size
            case OpenScene():
                return isinstance(answer, Opened)
            case CloseScene():
                return isinstance(answer, Closed)
            case Pick():
                return isinstance(answer, Picked)
            case Export():
                return isinstance(answer, Exported)

    def resolve(self, result: Reply | Exception) -> None:
        """Give the reply, or the error that takes its place, to whoever still waits for it."""
        if self.reply.done():
            return
        if isinstance(result, Exception):
            self.reply.set_exception(result)
            self.reply.exception()  # marks it as seen: nobody may be left to look
        else:
            self.reply.set_result(result)
