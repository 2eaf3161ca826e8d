"""A process that compiles: what stdin has are calls of Warp's native compilers, what stdout gets is what they return.

Started by gpu.core.compilers; it imports neither ours nor Warp, so that it is there in a tenth of a second.
"""

import ctypes
import os
import pickle
import signal
import sys
import threading
import time
from typing import Any


def value_of(type_name: str, argument: Any) -> Any:
    """An argument as a native function takes it: a number or text of that type of ctypes, or texts, which end with a
    null, where it is a pointer.
    """
    if isinstance(argument, tuple):
        return (ctypes.c_char_p * (len(argument) + 1))(*argument, None)
    return getattr(ctypes, type_name)(argument)


def end_with(parent: int) -> None:
    """End in the midst of a call, which may take a minute, once the parent is gone."""
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def main(parent: int) -> None:
    """Call the functions, (library, name, names of types, arguments), one after the other until stdin ends."""
    # Of a terminal it reaches all: the parent ends this by closing the pipe.
    for sign in (signal.SIGINT, signal.SIGHUP):
        signal.signal(sign, signal.SIG_IGN)
    threading.Thread(target=end_with, args=(parent,), daemon=True).start()
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # for what compilers print
    while True:
        try:
            library, name, types, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        function = getattr(ctypes.CDLL(library), name)
        print(function(*map(value_of, types, arguments)), file=answers, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
