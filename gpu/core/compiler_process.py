"""A process that compiles kernels for GPUs: one job a line of stdin, its outcome a line of stdout.

Started by gpu.core.compilers with the path of Warp's library; it imports nothing of ours, nor Warp, and is there in a
tenth of a second.
"""

import ctypes
import json
import signal
import sys
from pathlib import Path
from typing import Any

_TEXT, _NUMBER, _FLAG = ctypes.c_char_p, ctypes.c_int, ctypes.c_bool
# Of `wp_cuda_compile_program` of Warp 1.19: source, name, architecture and its suffix, folders of headers, switches,
# what comes out, folder of precompiled headers, and what is to be linked.
_ARGUMENTS: list[Any] = [
    _TEXT, _TEXT, _NUMBER, _TEXT, _TEXT, _NUMBER, ctypes.c_void_p, _FLAG, _NUMBER, *(_FLAG,) * 7, _TEXT, _TEXT,
    ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p
]  # fmt: skip


def main(library: str, headers: str) -> None:
    """Compile until stdin ends."""
    # Of a terminal it reaches all: the parent ends this by closing the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    build = ctypes.CDLL(library).wp_cuda_compile_program
    build.argtypes, build.restype = _ARGUMENTS, ctypes.c_size_t
    for line in sys.stdin:
        job = json.loads(line)
        source = Path(job["source"])
        error = build(
            source.read_bytes(), source.name.encode(), job["architecture"], job["suffix"].encode(), headers.encode(),
            0, None, job["debug"], job["level"], False, job["verify_fp"], job["fast_math"], job["fuse_fp"],
            job["lineinfo"], False, job["precompiled_headers"], job["out"].encode(), None, 0, None, None, None,
        )  # fmt: skip
        print(error, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
