"""The short looping pictures of the documentation: `python -m tests.bench.loops docs [NAME …]`.

Each is a built-in scene with other edits, or another time, in each picture, written as DIR/loop-NAME.webp.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path

from PIL import Image

from gpu.core.device import choose_device
from gpu.scene.edits import ObjectEdit, SceneEdits, edited
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from server.cli.studio import PictureOptions, Studio

SIZE = (320, 180)
PICTURES, MILLISECONDS = 16, 120
QUALITY = 70  # of WebP
# Of each picture: on a GPU as a view that rests has it; on a CPU few, and one frame.
BEST = RenderSettings(frames=32)
FEW = RenderSettings(sp_clusters=1024, vpl_clusters=256, vpls=4096)


@dataclass(frozen=True)
class Loop:
    """camera: its number in the scene; edits: at a share of the loop, from 0 to 1."""

    scene: str
    camera: int
    edits: Callable[[float], SceneEdits]


def _carried(share: float) -> SceneEdits:
    """The lamp goes around below the ceiling."""
    angle = 2.0 * pi * share
    offset = (0.13 * sin(angle), -0.11 - 0.05 * cos(2.0 * angle), 0.13 * cos(angle))
    return SceneEdits(objects={"light": ObjectEdit(offset=offset)})


def _turned(share: float) -> SceneEdits:
    """The glass cube turns, with what is in it: from each quarter to the next it looks the same but for the ring."""
    turn = ObjectEdit(rotation=(0.0, 360.0 * share, 0.0))
    return SceneEdits(objects={"glass": turn, "torus": turn})


LOOPS = {
    "light": Loop("cornell-box", 1, _carried),
    "glass": Loop("glass-box", 1, _turned),
    "water": Loop("water-box", 1, lambda share: SceneEdits(time=4.0 * share)),
}


def pictures(loop: Loop) -> list[Image.Image]:
    """The loop's pictures."""
    scene, made = load_scene(loop.scene), list[Image.Image]()
    settings = BEST if choose_device(None).is_cuda else FEW
    studio = Studio(edited(scene, loop.edits(0.0)), PictureOptions(SIZE, None, settings))
    for number in range(PICTURES):
        if number:
            studio.show(edited(scene, loop.edits(number / PICTURES)))
        frame = studio.picture(scene.cameras[loop.camera], (number, PICTURES))
        made.append(Image.fromarray(frame.pixels().copy()))
    return made


def main(folder: Path, names: list[str]) -> None:
    """Write the loops of these names, or all of them, into a folder."""
    for name in names or LOOPS:
        first, *others = pictures(LOOPS[name])
        file = folder / f"loop-{name}.webp"
        first.save(file, save_all=True, append_images=others, duration=MILLISECONDS, loop=0, quality=QUALITY, method=6)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: python -m tests.bench.loops FOLDER [NAME …]")
    main(Path(sys.argv[1]), sys.argv[2:])
