"""The scene of a command, read by a process of its own (server.cli.read_scene)."""

import os
import pickle
import signal
from subprocess import PIPE, Popen
from tempfile import TemporaryFile

from gpu.child_process import clean_environment, module_command
from gpu.errors import SceneError, UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import ImportOptions
from gpu.scene.load import load_scene
from gpu.scene.types import Scene
from server.cli.read_scene import ReadRequest

_READ = module_command("server.cli.read_scene")


def read_scene(source: str, options: ImportOptions) -> Scene:
    """The scene `source`, a built-in name or a file, read as `options` say.

    Raises UserError when it cannot be read, also where the library that reads it crashes.
    """
    if source in BUILTIN:
        return load_scene(source, options=options)
    request = ReadRequest(source=source, options=options).model_dump_json().encode()
    with TemporaryFile() as printed:
        with Popen(
            [*_READ, str(os.getpid())], stdin=PIPE, stdout=PIPE, stderr=printed, env=clean_environment()
        ) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                process.stdin.write(request)
                process.stdin.close()
                found: Scene | str = pickle.load(process.stdout)
            except (EOFError, pickle.UnpicklingError, BrokenPipeError):
                found = ""
            except BaseException:
                process.kill()
                raise
        if found == "":
            printed.seek(0)
            raise SceneError(source, "", _death(process.returncode, printed.read().decode("utf-8", "replace")))
    if isinstance(found, str):
        raise UserError(found)
    return found


def _death(status: int, printed: str) -> str:
    """Why a process ended without an answer, of which `printed` tells, too."""
    if status == -signal.SIGKILL:  # nobody here did it
        return "its reader was killed by the system, which ran out of memory; simplify it"
    ended = signal.Signals(-status).name if status < 0 else f"status {status}"
    last = printed.strip().rpartition("\n")[2][-200:]
    return f"cannot be read: its reader ended with {ended}; the file is broken{f' ({last})' if last else ''}"
