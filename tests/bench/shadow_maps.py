"""`rsm-disks` beside its paper, path tracing of one bounce and the other methods.

For each scene and each of the paper's three settings: times of all stages in a walk, `map-clusters` beside the paper's
(importance and clustering), active clusters, errors against all pixels of the maps as VPLs, without shadows as in the
paper and with them, and against path tracing. And flicker against all pixels, of clusters that are kept and of ones
that begin anew in each frame, while the camera walks, while a bulb does, and while both do.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import LightData
from gpu.renderer import Renderer
from gpu.scene.types import Camera, Floats, Light, LightKind
from gpu.settings import Method, RenderSettings, Skips
from gpu.vpl.light_sets import LightSets
from tests.bench.all_pixels import AllPixels
from tests.bench.figures import flicker
from tests.bench.store import Row, Task
from tests.bench.subjects import Size, Subject
from tests.bench.suite import Suite
from tests.bench.temporal import FRAMES, QUICK_FRAMES, walk
from tests.bench.timing import measure_frames

# Clusters, sides of maps and times [ms] of the paper's Table 1.
PAPER = ((256, 128, 0.92), (1024, 128, 3.2), (1024, 256, 9.5))
FLICKER_SIZE: Size = (320, 240)
PATHS = 1024
# As it comes, whose errors are against path tracing; and without near-field light, which all pixels have not either.
VARIANTS: dict[str, dict[str, Any]] = {
    "usual": {},
    "with_shadows": {"near_field": False},
    "without_shadows": {"near_field": False, "indirect_shadows": False},
}
MOVES = "camera", "bulb", "both"
BULB_STEP = 0.01  # of the scene's extent, a frame


def settings_of(suite: Suite, clusters: int, side: int, **changes: Any) -> RenderSettings:
    """`rsm-disks` with as many clusters and such maps."""
    quick = {"vpl_clusters": suite.count(clusters), "shadow_map": 64 if suite.quick else side}
    return suite.settings(method=Method.RSM_DISKS, bounces=1, **quick, **changes)


def measure_setting(suite: Suite, name: str, clusters: int, side: int, paper_ms: float) -> Row:
    """One scene with one of the paper's settings."""
    subject, settings = suite.subject(name), settings_of(suite, clusters, side)
    light_sets = LightSets(subject.device_scene)
    row: Row = {"scene": name, "size": list(subject.size), "clusters": clusters, "side": side, "paper_ms": paper_ms}
    for what, changes in VARIANTS.items():
        choice = settings.model_copy(update=changes)
        renderer = Renderer(subject.device_scene, subject.size, choice, light_sets=light_sets)
        measured = measure_frames(renderer, subject.camera, suite.frames, walks=True)
        reference = one_bounce(suite, name, Method.PATH).radiance
        if changes:
            reference = AllPixels(subject, choice, light_sets).render(subject.camera)
        row[what] = {**measured.row(), "errors": suite.errors(measured.radiance, reference)}
    return row


def one_bounce(suite: Suite, name: str, method: Method) -> Any:
    """Frames of one bounce by another method; of path tracing one, of many paths."""
    subject = suite.subject(name)
    samples = {"samples": suite.count(PATHS)} if method is Method.PATH else {}
    renderer = Renderer(subject.device_scene, subject.size, suite.settings(method=method, bounces=1, **samples))
    number = 1 if method is Method.PATH else suite.frames
    return measure_frames(renderer, subject.camera, number, number // 5, walks=True)


def measure_other(suite: Suite, name: str, method: Method) -> Row:
    """Another method's frames of one bounce: times, and errors against path tracing."""
    measured, truth = one_bounce(suite, name, method), one_bounce(suite, name, Method.PATH).radiance
    size = list(suite.subject(name).size)
    return {
        "scene": name,
        "size": size,
        "method": method,
        **measured.row(),
        "errors": suite.errors(measured.radiance, truth),
    }


def set_bulb(light_sets: LightSets, light: Light) -> None:
    """Have the table's last light be this one."""
    lights = light_sets.table.lights.numpy().copy()
    lights[-1]["position"] = light.position
    light_sets.table.lights.assign(lights.astype(LightData.numpy_dtype()))


def frames_of(suite: Suite, subject: Subject, moves: str) -> tuple[LightSets, list[tuple[Camera, Light]], Subject]:
    """A walk of the camera, of a bulb, or of both (MOVES), in the subject's scene with a bulb in it."""
    scene, number = subject.device_scene.scene, QUICK_FRAMES if suite.quick else FRAMES
    bulb = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.0, 0.1, 0.0))
    device = str(subject.device_scene.device)
    lit = Subject(subject.name, scene, FLICKER_SIZE, device, None, suite.cache, 1)
    lit.device_scene = DeviceScene(replace(scene, lights=[*scene.lights, bulb]), device)
    extent = 1.0 / scene.placement.scale
    cameras = walk(subject.camera, extent, number) if moves != "bulb" else [subject.camera] * number
    steps = range(number) if moves != "camera" else [0] * number
    bulbs = [replace(bulb, position=(BULB_STEP * step, 0.1, 0.0)) for step in steps]
    return LightSets(lit.device_scene), [*zip(cameras, bulbs, strict=True)], lit


def pictures(
    light_sets: LightSets, path: list[tuple[Camera, Light]], render: Callable[[Camera], Floats]
) -> Iterator[Floats]:
    """Of each camera with its bulb."""
    for camera, light in path:
        set_bulb(light_sets, light)
        yield render(camera).copy()


def measure_flicker(suite: Suite, name: str, moves: str, *, shadows: bool) -> Row:
    """Flicker against all pixels, of kept clusters and of ones that begin anew.

    Without shadows it is that of the maps' clusters alone; with them SP clusters, kept or anew, too, have theirs.
    """
    light_sets, path, lit = frames_of(suite, suite.subject(name), moves)
    clusters, side, _ = PAPER[1]
    skip = Skips(unchanged_camera=False)
    settings = settings_of(suite, clusters, side, skip=skip, indirect_shadows=shadows, near_field=False)
    truth = np.stack([*pictures(light_sets, path, AllPixels(lit, settings, light_sets).render)])
    row: Row = {"scene": name, "size": list(lit.size), "frames": len(path)}
    row |= {"moves": moves, "shadows": shadows}
    for what, kept in (("kept", True), ("anew", False)):
        choice = settings.model_copy(update={"skip": skip.model_copy(update={"kept_clusters": kept})})
        renderer = Renderer(lit.device_scene, lit.size, choice, light_sets=light_sets)
        frames = pictures(light_sets, path, lambda camera, by=renderer: by.render(camera, walks=True).radiance())
        row[what] = asdict(flicker(np.stack([*frames]), truth))
    return row


def run(suite: Suite) -> None:
    """The part of the command line."""
    tasks = []
    for name in suite.scene_names():
        label = suite.label(name)
        tasks += [
            Task(f"{label} {clusters} of {side}²", partial(measure_setting, suite, name, clusters, side, ms))
            for clusters, side, ms in PAPER
        ]
        others = [method for method in Method if method not in (Method.RSM_DISKS, Method.PATH)]
        tasks += [Task(f"{label} {method}", partial(measure_other, suite, name, method)) for method in others]
        for moves, shadows in product(MOVES, (False, True)):
            measure = partial(measure_flicker, suite, name, moves, shadows=shadows)
            tasks.append(Task(f"{label} flicker, {moves}{' with shadows' if shadows else ''}", measure))
    suite.run("shadow_maps", tasks)
