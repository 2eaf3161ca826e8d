"""Reads one scene in a process of its own, `python -m server.scenes.check_scene`: what a broken file can do ends with
it.

stdin has a CheckRequest as JSON, stdout gets its Checked or Refused. The process first limits itself: memory,
processor time, no new files (but for what an archive holds, and for formats whose library writes one in memory), few
open ones.
"""

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
from gpu.scene.load import WRITTEN_IN_MEMORY, load_scene
from gpu.scene.types import Scene
from server.scenes.archives import unpack
from server.scenes.checker import Checked, CheckRequest, Refused, SceneSize
from server.scenes.scene_info import describe_scene

MAX_OPEN_FILES = 64


def check(request: CheckRequest) -> Checked | Refused:
    """Read the scene under the limits, which stay in force afterwards."""
    _limit(RLIMIT_CORE, 0)
    _limit(RLIMIT_AS, request.memory_bytes)
    _limit(RLIMIT_CPU, ceil(request.seconds) + 1)
    _limit(RLIMIT_NOFILE, MAX_OPEN_FILES)
    source = request.source
    try:
        if request.folder is not None:
            _limit(RLIMIT_FSIZE, request.max_unpacked_bytes)
            source = str(unpack(Path(source), Path(request.folder), request.max_unpacked_bytes))
        written = Path(source).suffix.lower() in WRITTEN_IN_MEMORY
        _limit(RLIMIT_FSIZE, request.memory_bytes if written else 0)
        scene = load_scene(source, request.limits, request.options)
        return Checked(source=source, info=describe_scene(source, scene, request.options), size=measure(scene))
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


def _limit(resource: int, value: int) -> None:
    """Lower a limit of this process; one that is lower already stays."""
    _, hard = getrlimit(resource)
    bound = value if hard == RLIM_INFINITY else min(value, hard)
    setrlimit(resource, (bound, bound))


if __name__ == "__main__":
    answer = check(CheckRequest.model_validate_json(sys.stdin.buffer.read()))
    sys.stdout.buffer.write(answer.model_dump_json().encode())
