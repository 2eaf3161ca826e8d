"""General kernels compiled ahead, by which scenes to come are shown at once while their own are compiled: by a process
that has what others leave of the cores, `python -m server.worker.warm_ahead PARENT ARCHITECTURE`.

PARENT is the id of the process that starts it, with which it ends. Once all are there a file in Warp's cache says so.
"""

import fcntl
import logging
import os
import sys
from hashlib import sha256
from pathlib import Path
from subprocess import DEVNULL, Popen

import warp as wp

import gpu
from gpu.child_process import clean_environment, module_command
from gpu.device_scene.upload import DeviceScene
from gpu.scene.builtin import BUILTIN
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from gpu.warm_up import warm_up_for
from server.scenes import walls

NICENESS = 19
log = logging.getLogger("lumenwalk.renderer")


def begin(device: wp.Device) -> Popen[bytes] | None:
    """Have general kernels compiled for a GPU from now on; None where that is done already or no process can be had,
    and on a CPU, whose cores frames need.
    """
    if not device.is_cuda or _there(device.arch).exists():
        return None
    log.info("compiling kernels for scenes to come, once, on what frames leave of the cores")
    command = (*module_command("server.worker.warm_ahead"), str(os.getpid()), str(device.arch))
    # No GPU is needed for that, nor memory of one taken.
    environment = clean_environment() | {"CUDA_VISIBLE_DEVICES": ""}
    try:
        return Popen(command, stdin=DEVNULL, stdout=DEVNULL, env=environment, start_new_session=True)
    except OSError as error:
        log.warning("kernels for scenes to come are not compiled ahead: %s", error)
        return None


def warm_ahead(architecture: int) -> None:
    """Compile what GPUs of this compute capability times ten lack of general kernels, unless another process is at it:
    what frames of all built-in scenes launch, which have everything that general kernels are for.
    """
    there = _there(architecture)
    with there.with_suffix(".lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        for name in BUILTIN:
            warm_up_for(architecture, DeviceScene(load_scene(name), "cpu").generalised(), RenderSettings())
        there.touch()


def _there(architecture: int) -> Path:
    """The file that says that all are there, of this code and Warp."""
    sources = sorted(Path(gpu.__file__).parent.rglob("*.py"))
    state = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in sources]
    digest = sha256(repr((wp.__version__, state)).encode()).hexdigest()[:16]
    return Path(wp.config.kernel_cache_dir) / f"general_{architecture}_{digest}"


def _start_warp() -> None:
    """Have Warp find its cache, and not say on stderr that it finds no GPU."""
    stderr = os.dup(2)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    wp.init()
    os.dup2(stderr, 2)
    os.close(stderr)


if __name__ == "__main__":
    walls.end_with_parent(int(sys.argv[1]))
    os.nice(NICENESS)
    _start_warp()
    warm_ahead(int(sys.argv[2]))
