"""Files in folders that the service keeps from one run to the next, where others may have put what they like."""

import os
from pathlib import Path
from stat import S_ISREG


def read_plain(file: Path, most_bytes: int) -> bytes:
    """What a file holds. Raises OSError or ValueError for one that is a link, a pipe or a device, or too large."""
    descriptor = os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(descriptor, "rb") as source:
        status = os.fstat(descriptor)
        if not S_ISREG(status.st_mode) or status.st_size > most_bytes:
            raise ValueError("no plain file, or too large")
        return source.read(most_bytes)
