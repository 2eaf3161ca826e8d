"""Errors of a render in a process of its own: HDR-FLIP takes longer than many a frame. Imports no renderer."""

import os
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import asdict
from multiprocessing import get_context
from typing import Any

from numpy.typing import ArrayLike

from gpu.film.metrics import measure

PROCESSES = 8


def errors_of(render: ArrayLike, reference: ArrayLike) -> dict[str, Any]:
    """Every error of gpu.film.metrics, by name."""
    return asdict(measure(render, reference))


class ErrorPool:
    """Computes errors on the side; started when first used."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, render: ArrayLike, reference: ArrayLike) -> Future[dict[str, Any]]:
        """`errors_of`, later."""
        if self._pool is None:
            # HDR-FLIP's threads of one process would fight those of the others; read when the processes start.
            os.environ.setdefault("OMP_NUM_THREADS", "1")
            self._pool = ProcessPoolExecutor(PROCESSES, get_context("spawn"))
        return self._pool.submit(errors_of, render, reference)
