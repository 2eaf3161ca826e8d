"""How time grows: over shading points, VPLs and triangles, one of them at a time."""

from functools import partial
from time import perf_counter
from typing import Any

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.settings import RenderSettings
from tests.bench.hall import make_hall
from tests.bench.store import Row, Task
from tests.bench.subjects import Size
from tests.bench.suite import HALL, VPLS, Suite
from tests.bench.timing import light_times, measure_frames

SCENE = "living-room"
SIZE: Size = (1024, 576)
SIZES: tuple[Size, ...] = ((3840, 2160), (1920, 1080), (960, 540), (480, 270), (2720, 1530), (1360, 765), (240, 135))
VPL_COUNTS = (1_000_000, VPLS, 10_000, 1000, 300_000, 30_000, 3000)
TRIANGLES = (10_000, 1_000_000, 100_000, 10_000_000, 300_000, 3_000_000, 30_000)
LIGHT_REPEATS = 20
# A quick run's sides of an image are so much shorter.
QUICK_SIDES = 16


def run(suite: Suite) -> None:
    """The part of the command line: over SPs and VPLs of the first scene named, and triangles of the hall.

    The ends of each range come before what lies between.
    """
    name = suite.names[0] if suite.names else SCENE
    share = QUICK_SIDES if suite.quick else 1
    fixed = (SIZE[0] // share, SIZE[1] // share)
    residents: dict[int, DeviceScene] = {}

    def scene() -> DeviceScene:
        if 0 not in residents:
            file = f"{suite.scenes}/{name}.glb" if suite.scenes else name
            residents[0] = DeviceScene(load_scene(file), suite.device)
        return residents[0]

    def time_frames(device_scene: DeviceScene, size: Size, settings: RenderSettings) -> dict[str, Any]:
        return measure_frames(Renderer(device_scene, size, settings), device_scene.scene.cameras[0], suite.frames).row()

    def over_sps(size: Size) -> Row:
        return {"axis": "sps", "x": size[0] * size[1], "scene": name, **time_frames(scene(), size, suite.settings())}

    def over_vpls(vpls: int) -> Row:
        settings = suite.settings(vpls=vpls)
        row = {"axis": "vpls", "x": vpls, "scene": name, **time_frames(scene(), fixed, settings)}
        return {**row, "light_ms": light_times(scene(), settings, min(LIGHT_REPEATS, suite.frames))}

    def over_triangles(triangles: int) -> Row:
        hall = make_hall(triangles)
        begun = perf_counter()
        device_scene = DeviceScene(hall, suite.device)
        upload_ms = 1e3 * (perf_counter() - begun)
        settings = suite.settings()
        row = {"axis": "triangles", "x": len(hall.triangles), "scene": HALL, "upload_ms": upload_ms}
        row |= time_frames(device_scene, fixed, settings)
        return {**row, "light_ms": light_times(device_scene, settings, min(LIGHT_REPEATS, suite.frames))}

    tasks = []
    for size, vpls, triangles in zip(SIZES, VPL_COUNTS, TRIANGLES, strict=True):
        size = (size[0] // share, size[1] // share)
        vpls, triangles = suite.count(vpls), suite.count(triangles)
        tasks.append(Task(f"sps {name} {size[0]}x{size[1]}", partial(over_sps, size)))
        tasks.append(Task(f"vpls {name} {vpls}", partial(over_vpls, vpls)))
        tasks.append(Task(f"triangles {triangles}", partial(over_triangles, triangles)))
    suite.run("growth", tasks)
