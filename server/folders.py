"""Folders that one process holds, by a lock of the kernel, which goes with the process however that ends."""

import fcntl
import logging
import os
import shutil
from contextlib import suppress
from errno import ENOLCK, ENOSYS, EOPNOTSUPP
from pathlib import Path
from stat import S_ISDIR
from tempfile import gettempdir, mkdtemp

LOCK = ".lumenwalk.lock"
PREFIX = "lumenwalk-"
_WITHOUT_LOCKS = (ENOLCK, ENOSYS, EOPNOTSUPP)  # what file systems say that have none
log = logging.getLogger("lumenwalk.folders")


def hold(folder: Path) -> int | None:
    """Hold `folder` for this process until the descriptor returned is closed; None when another process holds it.

    Raises OSError when nothing can be written there.
    """
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return None
    except OSError as error:
        if error.errno not in _WITHOUT_LOCKS:
            os.close(descriptor)
            raise
        log.warning("%s is on a file system without locks: see that no other service uses it", folder)
    return descriptor


class TemporaryFolder:
    """A new folder among the system's temporary ones; those that processes of this program left behind go first."""

    def __init__(self) -> None:
        """Raises OSError when there can be none."""
        remove_abandoned(Path(gettempdir()))
        self._lock: int | None = None
        while self._lock is None:  # another process may take it for abandoned before it is held
            self.path = Path(mkdtemp(prefix=PREFIX)).resolve()
            self._lock = hold(self.path)

    def remove(self) -> None:
        """Delete it with all that is in it."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def remove_abandoned(parent: Path) -> None:
    """Delete the temporary folders in `parent` whose process is gone; those of other users are left alone."""
    for folder in parent.glob(f"{PREFIX}*"):
        with suppress(OSError):
            status = folder.lstat()
            if not S_ISDIR(status.st_mode) or status.st_uid != os.geteuid() or not (folder / LOCK).is_file():
                continue
            lock = hold(folder)
            if lock is not None:
                log.info("%s was left behind by a process that is gone: deleted", folder)
                shutil.rmtree(folder, ignore_errors=True)
                os.close(lock)
