"""Seconds from a start to a service's first picture: `python -m tests.bench.first_picture [DEVICE] [SCENE …]`.

Each scene with no kernels kept: a picture (`lumenwalk render`), all that a service takes (`lumenwalk warm`) and a
service; then a service that starts with the kernels of the first scene kept, and with its own. The start of Python and
Warp, and reading the scene, are in all of them.
"""

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

LUMENWALK = (sys.executable, "-c", "import sys; from server.cli.main import main; sys.exit(main())")
SCENES = ("cornell-box", "living-room", "conference-room")


def seconds(folder: Path, *arguments: str) -> float:
    """How long a command takes with its kernels in a folder; CalledProcessError where it fails."""
    begun = perf_counter()
    subprocess.run(
        (*LUMENWALK, *arguments), env=os.environ | {"WARP_CACHE_PATH": str(folder)}, stdout=sys.stderr, check=True
    )
    return perf_counter() - begun


def seconds_to_ready(folder: Path, device: str, scene: str) -> float:
    """Until a service of a scene prints its address, which it does when a frame can be had."""
    begun = perf_counter()
    with subprocess.Popen(
        (*LUMENWALK, "serve", "--port=0", f"--device={device}", f"--scene={scene}"),
        env=os.environ | {"WARP_CACHE_PATH": str(folder)},
        stdout=subprocess.PIPE,
    ) as service:
        assert service.stdout is not None
        try:
            if not service.stdout.readline():
                raise RuntimeError(f"{scene}: the service ended before a frame could be had")
            return perf_counter() - begun
        finally:
            service.terminate()


def main(device: str, scenes: tuple[str, ...]) -> None:
    """Print a line for each scene."""
    with TemporaryDirectory() as temporary:
        root, kept = Path(temporary), Path(temporary) / "kept"
        print(f"{'scene':18} {'render':>7} {'warm':>7} {'serve':>7} {'first kept':>11} {'own kept':>9}  [s]")
        seconds(kept, "warm", f"--device={device}", scenes[0])
        for scene in scenes:
            picture = f"{root / 'picture.png'}"
            render = seconds(root / f"{scene}-render", "render", scene, picture, "--size=64x36", f"--device={device}")
            warm = seconds(root / f"{scene}-warm", "warm", scene, f"--device={device}")
            serve = seconds_to_ready(root / f"{scene}-serve", device, scene)
            first, own = (seconds_to_ready(kept, device, scene) for _ in range(2))
            print(f"{scene:18} {render:7.1f} {warm:7.1f} {serve:7.1f} {first:11.1f} {own:9.1f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "cuda:0", tuple(sys.argv[2:]) or SCENES)
