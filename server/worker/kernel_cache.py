"""The folder that Warp keeps compiled kernels in, looked at before the first one is compiled."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

from gpu.errors import UserError

LEAST_BYTES = 64 * 2**20  # that have to be free: about as much as all kernels of a device take


@contextmanager
def needs_kernel_cache() -> Iterator[None]:
    """UserError for what goes wrong within as Warp makes its folder."""
    try:
        yield
    except OSError as error:
        raise _refusal(f"cannot be made: {error.strerror or error}", str(error.filename or "")) from None


def check_kernel_cache(folder: str) -> None:
    """UserError when nothing can be written into the folder, or it has no room for kernels."""
    try:
        with TemporaryFile(dir=folder) as file:
            file.write(bytes(2**16))
            file.flush()
            os.fsync(file.fileno())
        free = shutil.disk_usage(folder).free
    except OSError as error:
        raise _refusal(f"cannot be written: {error.strerror or error}", folder) from None
    if free < LEAST_BYTES and not any(Path(folder).rglob("*.meta")):  # else kernels are there already
        raise _refusal(f"has {free / 1e6:.0f} MB free, {LEAST_BYTES / 1e6:.0f} MB are needed", folder)


def _refusal(problem: str, folder: str) -> UserError:
    return UserError(f"kernel cache {folder}: {problem}; set WARP_CACHE_PATH to another folder, or mend this one")
