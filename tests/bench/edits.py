"""What live edits of a scene cost: `python -m tests.bench.edits [DEVICE] [SCENE …]` prints a line of JSON a scene and
kind of edit.

Each frame of a walk has an edit that was never seen before, as while somebody drags a slider or carries a light, or an
animation plays. Medians [ms]: `edit`, putting it on the device; `frame`, and `stages`, those of that; `moving`, edit
and frame. Beside them `first`, edit and first frame; `walking`, a frame that nothing changed for; and `anew`, how many
of the edits needed renderers, arrays and graphs of their own.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
import warp as wp

from gpu.core.device import choose_device
from gpu.renderer import Renderer
from gpu.scene.animation.motion import STILL, Animation, Body, Channel, Interpolation, Motion, Property
from gpu.scene.camera import rotated
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits
from gpu.scene.load import load_scene
from gpu.scene.parts import lights_of, material_ids
from gpu.scene.types import Doubles, Light, LightKind, Scene
from gpu.settings import RenderSettings
from server.wire.worker import SceneRef
from server.worker.loaded_scene import LoadedScene, build, edit

SCENES = ("cornell-box", "living-room", "conference-room")
SIZE, ROUNDS, WARM_UP = (1024, 576), 24, 4
STEP = 0.002  # of the scene's extent, that a light or an object moves in a frame
Edit = Callable[[int], SceneEdits]


def with_bulb(scene: Scene) -> Scene:
    """`scene` with a point light in its middle."""
    middle = tuple(0.5 * (low + high) for low, high in zip(*scene.bounds, strict=True))
    placed = (middle[axis] - scene.placement.centre[axis] for axis in range(3))
    position = tuple(float(value * scene.placement.scale) for value in placed)
    x, y, z = position
    return replace(scene, lights=(*scene.lights, Light("bench bulb", LightKind.POINT, (0.1, 0.1, 0.1), (x, y, z))))


def edits_of(scene: Scene) -> dict[str, Edit]:
    """By name, the kinds of edits and the one of each frame."""
    low, high = scene.bounds
    extent = max(b - a for a, b in zip(low, high, strict=True))
    x, y, z = (0.5 * (a + b) for a, b in zip(low, high, strict=True))
    material = material_ids(scene)[0]

    def light(**change: Any) -> SceneEdits:
        return SceneEdits(lights={"bench bulb": LightEdit(**change)})

    def surface(**change: Any) -> SceneEdits:
        return SceneEdits(materials={material: MaterialEdit(**change)})

    kinds: dict[str, Edit] = {
        "dim": lambda number: light(intensity=0.5 + number / 100.0),
        "mix": lambda number: mixed(scene, 0.5 + number / 100.0),
        "recolour": lambda number: light(color=(1.0, 0.5 + number / 100.0, 0.5)),
        "move light": lambda number: light(position=(x + number * STEP * extent, y, z)),
        "material": lambda number: surface(color=(0.5, 0.3 + number / 100.0, 0.5)),
    }
    inner = inner_objects(scene)
    if inner:
        one, a = inner[0]
        step = (a[1] - low[1]) / (2 * (ROUNDS + WARM_UP))
        kinds["move object"] = lambda number: SceneEdits(objects={one: ObjectEdit(offset=(0.0, -step * number, 0.0))})
    if scene.motion is not None:
        seconds, frames = scene.motion.animations[0].seconds, ROUNDS + WARM_UP
        kinds["time"] = lambda number: SceneEdits(time=seconds * (number + 1) / (frames + 1))
    return kinds


def mixed(scene: Scene, factor: float) -> SceneEdits:
    """Every other light dimmed, and the others brightened."""
    factors = {part.id: factor if number % 2 else 2.0 - factor for number, part in enumerate(lights_of(scene))}
    return SceneEdits(lights={one: LightEdit(intensity=value) for one, value in factors.items()})


def with_motion(scene: Scene, seconds: float = 4.0) -> Scene:
    """`scene` with an animation in which an object of it, which lies within it, goes halfway to its floor; as it is
    where there is none, or it has one.
    """
    inner = inner_objects(scene)
    if scene.motion is not None or not inner:
        return scene
    one, low = inner[0]
    own = np.flatnonzero(scene.vertex_object == scene.objects.index(one))
    assert np.array_equal(own, own[0] + np.arange(len(own)))
    faces = scene.triangles[(scene.triangles[:, 0] >= own[0]) & (scene.triangles[:, 0] <= own[-1])]
    positions = scene.vertices[own].astype(np.float64) / scene.placement.scale + scene.placement.centre
    body = Body(
        node=0,
        positions=positions,
        normals=scene.normals[own].astype(np.float64),
        triangles=faces.astype(np.int64) - own[0],
        instances=np.eye(4)[None],
        first_vertex=int(own[0]),
        vertices=np.arange(len(own), dtype=np.int32),
    )
    down = np.array([[0.0, 0.0, 0.0], [0.0, 0.5 * (scene.bounds[0][1] - low[1]), 0.0]])
    times = np.array([0.0, seconds])
    channel = Channel(0, Property.TRANSLATION, Interpolation.LINEAR, times, down[:, None])
    rest = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]])
    animation = Animation("down", seconds, (channel,))
    motion = Motion(np.array([STILL], np.int32), np.eye(4)[None], rest, (animation,), (body,))
    return replace(scene, motion=motion)


def inner_objects(scene: Scene) -> list[tuple[str, Doubles]]:
    """The objects that lie within the scene's box, and the least coordinates of each."""
    low, high = scene.bounds
    return [
        (one, a)
        for one, a, b in zip(scene.objects, *scene.object_boxes, strict=True)
        if all(c < d and e < f for c, d, e, f in zip(low, a, b, high, strict=True))
    ]


class Frames:
    """Frames of a walk at a scene in a state after the other, as a worker renders them."""

    def __init__(self, base: LoadedScene, size: tuple[int, int], settings: RenderSettings) -> None:
        self._base, self._size, self._settings = base, size, settings
        self._state: LoadedScene | None = None
        self.anew, self.number = 0, 0

    def edit(self, edits: SceneEdits) -> None:
        """Have these edits."""
        state = edit(self._base, edits, self._state)
        if state is not self._state:
            self._state, self.anew = state, self.anew + 1
            self._renderer = Renderer(state.device_scene, self._size, self._settings, light_sets=state.light_sets)
            self._view = self._renderer.new_view()

    def frame(self) -> dict[str, float]:
        """Render one from a little further; the times of its stages [ms]."""
        self.number += 1
        camera = rotated(self._base.scene.cameras[0], 0.1 * self.number)
        return self._renderer.render(camera, view=self._view, walks=True).stats.stage_ms


def timed(device: wp.Device, work: Callable[[], Any]) -> tuple[float, Any]:
    """What `work` takes until the device has done it [ms], and its result."""
    wp.synchronize_device(device)
    begun = perf_counter()
    result = work()
    wp.synchronize_device(device)
    return 1e3 * (perf_counter() - begun), result


def measure(
    base: LoadedScene, edit_of: Edit, settings: RenderSettings, size: tuple[int, int] = SIZE, rounds: int = ROUNDS
) -> dict[str, Any]:
    """Medians of one kind of edit [ms]; the first WARM_UP frames, which load kernels, do not count."""
    frames, device = Frames(base, size, settings), base.device_scene.device
    found: dict[str, list[float]] = {}
    stages: dict[str, list[float]] = {}

    def note(**times: float) -> None:
        for name, value in times.items():
            found.setdefault(name, []).append(value)

    first = 0.0
    for number in range(WARM_UP + rounds):
        edits = edit_of(number)
        editing, _ = timed(device, lambda edits=edits: frames.edit(edits))
        taken, parts = timed(device, frames.frame)
        if number == 0:
            first = editing + taken
        if number >= WARM_UP:
            note(edit=editing, frame=taken, moving=editing + taken)
            for name, value in parts.items():
                stages.setdefault(name, []).append(value)
    anew = frames.anew
    for _ in range(WARM_UP + rounds):
        note(walking=timed(device, frames.frame)[0])
    medians = {name: round(median(times[-rounds:]), 2) for name, times in found.items()}
    parts = {name: round(median(times), 3) for name, times in stages.items()}
    return {"first": round(first, 2), **medians, "anew": anew, "stages": parts}


def main(arguments: list[str]) -> None:
    device, scenes = choose_device((arguments or ["cuda:0"])[0]), arguments[1:] or SCENES
    for name in scenes:
        base = build(SceneRef(name, name), with_motion(with_bulb(load_scene(name))), device)
        for kind, edit_of in edits_of(base.scene).items():
            found = measure(base, edit_of, RenderSettings())
            print(json.dumps({"scene": name, "kind": kind, **found}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
