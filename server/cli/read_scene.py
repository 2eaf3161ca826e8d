"""Reads one scene in a process of its own, `python -m server.cli.read_scene PARENT`, so that no library that crashes
ends a command without a word; PARENT is the id of the process that starts it, with which it ends.

stdin has a ReadRequest as JSON; stdout gets, pickled, the Scene or, as text, what is wrong with it.
"""

import os
import pickle
import signal
import sys

from pydantic import BaseModel

from gpu.errors import SceneError, UserError
from gpu.scene.import_options import ImportOptions
from gpu.scene.load import load_scene
from gpu.scene.types import Scene
from server.scenes import walls


class ReadRequest(BaseModel):
    """The scene that is to be read, a built-in name or a file, and how."""

    source: str
    options: ImportOptions


def read(request: ReadRequest) -> Scene | str:
    """The scene, or the sentence that says what is wrong with it."""
    try:
        return load_scene(request.source, options=request.options)
    except UserError as error:
        return str(error)
    except (MemoryError, RecursionError):
        return str(SceneError(request.source, "", "takes more memory to read than there is; simplify it"))


if __name__ == "__main__":
    walls.end_with_parent(int(sys.argv[1]))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the command, which ends this process
    answer = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what libraries print is no part of the answer
    with answer:
        pickle.dump(read(ReadRequest.model_validate_json(sys.stdin.buffer.read())), answer, pickle.HIGHEST_PROTOCOL)
