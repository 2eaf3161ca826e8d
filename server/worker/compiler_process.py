"""The compilers' process, `python -m server.worker.compiler_process DESCRIPTOR`: compiles what a worker asks for over
that connection (server.worker.compilers), on all cores, until the worker closes it or ends.
"""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

import warp as wp


def work(connection: "Connection[Any, Any]") -> None:
    """Answer each request, a number with the compiler's name, arguments and options, with the number and None or, where
    that failed, what it said.
    """
    lock = Lock()

    def compile_one(number: int, compiler: str, arguments: tuple[Any, ...], options: dict[str, Any]) -> None:
        problem = None
        try:
            if compiler == "build_cuda":
                # Headers that NVRTC has read can be used again by the thread that read them.
                options |= {"pch_dir": wp._src.context.runtime.get_nvrtc_pch_dir()}
            getattr(wp._src.build, compiler)(*arguments, **options)
        except Exception as error:
            problem = str(error)
        with lock:
            connection.send((number, problem))

    wp.config.log_level = wp.LOG_WARNING
    wp.init()
    pool = ThreadPoolExecutor(os.cpu_count() or 1)
    while True:
        try:
            request = connection.recv()
        except (EOFError, OSError):
            return
        pool.submit(compile_one, *request)


if __name__ == "__main__":
    work(Connection(int(sys.argv[1])))
    os._exit(0)  # whoever asked for what is under way is gone
