"""Reads one scene in a process of its own, `python -m server.scenes.check_scene PARENT`, so that what a broken file can
do ends with it; PARENT is the id of the process that starts it, with which it ends.

stdin has a CheckRequest as JSON, stdout gets its Checked or Refused. The process first limits itself: memory,
processor time, no new files (but for what an archive holds, for formats whose library writes one in memory, and where
the scene itself is wanted), few open ones; then it puts up the walls of server.scenes.walls.
"""

import os
import sys
from math import ceil
from pathlib import Path
from resource import (
    RLIM_INFINITY,
    RLIMIT_AS,
    RLIMIT_CORE,
    RLIMIT_CPU,
    RLIMIT_FSIZE,
    RLIMIT_NOFILE,
    getrlimit,
    setrlimit,
)

from gpu.errors import SceneError
from gpu.scene.builtin import BUILTIN
from gpu.scene.load import READ_BY_A_PROCESS, WRITTEN_IN_MEMORY, load_scene
from gpu.scene.types import Scene
from server.scenes import walls
from server.scenes.archives import UnpackedError, unpack
from server.scenes.checked import Checked, CheckRequest, Refused, SceneSize
from server.scenes.packed_scene import write_scene
from server.scenes.scene_info import describe_scene

MAX_OPEN_FILES = 64


def check(request: CheckRequest) -> Checked | Refused:
    """Read the scene under the limits, which stay in force afterwards."""
    _limit(RLIMIT_CORE, 0)
    _limit(RLIMIT_AS, request.memory_bytes)
    _limit(RLIMIT_CPU, ceil(request.seconds) + 1, spare=1)  # the first ends it by SIGXCPU, which says why
    _limit(RLIMIT_NOFILE, MAX_OPEN_FILES)
    source = request.source
    walls.open_only(_belonging(request), [Path(request.folder)] if request.folder is not None else [])
    try:
        if request.folder is not None:
            _limit(RLIMIT_FSIZE, request.max_unpacked_bytes)
            source = str(unpack(Path(source), Path(request.folder), request.max_unpacked_bytes))
        suffix = Path(source).suffix.lower()
        walls.start_nothing(except_processes=suffix in READ_BY_A_PROCESS)
        written = suffix in WRITTEN_IN_MEMORY
        _limit(RLIMIT_FSIZE, request.memory_bytes if written or request.result is not None else 0)
        scene = load_scene(source, request.limits, request.options)
        if request.result is not None:
            with os.fdopen(request.result, "wb") as file:
                write_scene(scene, file)
        info = describe_scene(source, scene, request.options, in_environment=request.in_environment)
        return Checked(source=source, info=info, size=measure(scene))
    except UnpackedError as error:
        return Refused(field=error.field, problem=error.problem, unpacked_bytes=error.size)
    except SceneError as error:
        return Refused(field=error.field, problem=error.problem)
    except (MemoryError, RecursionError):
        problem = f"takes more than {request.memory_bytes} bytes of memory to read; simplify it, or raise"
        return Refused(field="", problem=f"{problem} check_memory_bytes of this server")


def measure(scene: Scene) -> SceneSize:
    """How much of everything the scene has."""
    pixels = {id(texture.pixels): texture.pixels.size // 4 for texture in scene.textures}
    return SceneSize(
        vertices=len(scene.vertices),
        triangles=len(scene.triangles),
        uv_sets=len(scene.uvs),
        colored=scene.colors is not None,
        materials=len(scene.materials),
        texels=sum(pixels.values()),
    )


def _belonging(request: CheckRequest) -> list[Path]:
    """The file of a scene, and the folder that its other files are in."""
    path = Path(request.source)
    if request.source in BUILTIN:
        return []
    return [path.resolve()] if request.folder is not None else [path.resolve(), path.parent.resolve()]


def _limit(resource: int, value: int, spare: int = 0) -> None:
    """Lower a limit of this process, the one that cannot be raised by `spare` less; one that is lower already stays."""
    _, hard = getrlimit(resource)
    soft, bound = (it if hard == RLIM_INFINITY else min(it, hard) for it in (value, value + spare))
    setrlimit(resource, (soft, bound))


if __name__ == "__main__":
    walls.end_with_parent(int(sys.argv[1]))
    answer = check(CheckRequest.model_validate_json(sys.stdin.buffer.read()))
    sys.stdout.buffer.write(answer.model_dump_json().encode())
