"""A log that clients can make grow only so fast, whatever they send or do not."""

import logging

from server.rate_limit import Bucket

RATE, BURST = 0.2, 10.0  # records a second of one logger, and at once
# What speaks of single connections: of broken requests and handshakes, of sockets, and what the service cuts off.
LOGGERS = ("uvicorn.error", "websockets.server", "asyncio", "lumenwalk.http")


class SparseLog(logging.Filter):
    """Lets few records pass; the next one that does says how many did not."""

    def __init__(self) -> None:
        super().__init__()
        self._bucket = Bucket(RATE, BURST)
        self._left_out = 0

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record passes."""
        if not self._bucket.spend():
            self._left_out += 1
            return False
        if self._left_out:
            record.left_out, self._left_out = self._left_out, 0
        return True


def make_sparse() -> None:
    """Let these loggers write little."""
    for name in LOGGERS:
        logger = logging.getLogger(name)
        if not any(isinstance(known, SparseLog) for known in logger.filters):
            logger.addFilter(SparseLog())
