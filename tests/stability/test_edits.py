"""After any edits a picture has the bits of one of the edited scene, put on the device anew.

The renderer goes on with what it has made of the states before, where they need no other arrays or kernels.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from devices import NEEDS_CUDA
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from pictures import CAMERA
from scenes import box, grey, quad, scene_of

from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.renderer import Renderer
from gpu.scene.camera import look_at, rotated
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.types import Doubles, Light, LightKind, Sky
from gpu.settings import Component, Method, RenderSettings, Skips
from gpu.vpl.light_sets import LightSets
from server.wire.worker import SceneRef
from server.worker.loaded_scene import LoadedScene, edit

SIZE = (24, 18)
# Any bit of what was before would show, however few of anything there are.
COUNTS = {"sp_clusters": 50, "vpls": 400, "vpl_clusters": 40, "photons": 1000, "gather_rays": 8, "samples": 1}
SHARES = st.sampled_from([0.0, 0.3, 1.0])
COLORS = st.tuples(SHARES, SHARES, SHARES)
PLACES = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
LIGHTS = st.builds(LightEdit, on=st.sampled_from([None, True, False]), color=st.none() | COLORS,
                   intensity=st.sampled_from([None, 0.0, 0.5, 20.0]))  # fmt: skip
MOVING = st.builds(LightEdit.model_copy, LIGHTS, update=st.fixed_dictionaries({"position": st.none() | PLACES}))
MATERIALS = st.builds(MaterialEdit, color=st.none() | COLORS, roughness=st.none() | SHARES, metallic=st.none() | SHARES,
                      emission=st.none() | COLORS)  # fmt: skip
OBJECTS = st.builds(
    ObjectEdit,
    visible=st.sampled_from([None, False]),
    offset=st.sampled_from([None, (0.1, 0.0, -0.1), (0.0, -0.2, 0.0)]),
    rotation=st.sampled_from([None, (0.0, 30.0, 0.0), (-90.0, 0.0, 45.0)]),
    scale=st.sampled_from([None, 0.5, 1.2]),
)
EDITS = st.builds(
    SceneEdits,
    lights=st.fixed_dictionaries({}, optional={"bulb": MOVING, "default": LIGHTS, "sky": LIGHTS, "sun": LIGHTS}),
    objects=st.fixed_dictionaries({}, optional={"lamp": OBJECTS, "block": OBJECTS}),
    materials=st.dictionaries(st.sampled_from(["default", "default (2)", "default (3)"]), MATERIALS),
)


@cache
def room(device: str = "cpu") -> DeviceScene:
    """A box with a hole in its ceiling, a lamp, a bulb and a sky."""
    walls = box()
    del walls[3]
    lamp = replace(quad((-0.2, 0.4, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1), name="lamp")
    block = replace(quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2), name="block")
    bulb = Light("bulb", LightKind.POINT, (0.1, 0.2, 0.1), (0.3, 0.3, 0.0))
    materials = [grey(0.7), grey(0.0, 5.0), grey(0.4)]
    return DeviceScene(scene_of([*walls, lamp, block], materials, lights=[bulb], sky=Sky((0.5, 0.6, 0.7))), device)


@pytest.mark.parametrize("method", list(Method))
@example(
    [
        SceneEdits(
            lights={"bulb": LightEdit(on=False), "sky": LightEdit(intensity=9.0)},
            materials={"default": MaterialEdit(color=(0.2, 0.1, 1.0), emission=(0.0, 1.0, 0.0))},
        )
    ]
)
@example(
    [
        SceneEdits(lights={"bulb": LightEdit(position=(0.1, 0.2, 0.1))}),
        SceneEdits(lights={"bulb": LightEdit(position=(-0.2, -0.3, 0.2)), "default": LightEdit(color=(1.0, 0.3, 0.0))}),
        SceneEdits(materials={"default": MaterialEdit(color=(0.9, 0.1, 0.1))}),
        SceneEdits(lights={"bulb": LightEdit(on=False), "default": LightEdit(intensity=0.0)}),
    ]
)
@example(
    [
        SceneEdits(objects={"block": ObjectEdit(offset=(0.1, 0.0, -0.1)), "lamp": ObjectEdit(offset=(0.1, -0.1, 0.1))}),
        SceneEdits(objects={"block": ObjectEdit(offset=(0.0, -0.2, 0.0), rotation=(20.0, 0.0, 70.0))}),
    ]
)
@example(  # where nothing reflects light there are no VPLs
    [
        SceneEdits(materials=dict.fromkeys(["default", "default (3)"], MaterialEdit(color=(0.0, 0.0, 0.0)))),
        SceneEdits(materials={"default": MaterialEdit(color=(0.9, 0.1, 0.1))}),
    ]
)
@example(  # a sun that the file has not
    [
        SceneEdits(lights={"sun": LightEdit(on=True, direction=(0.3, -1.0, 0.1))}),
        SceneEdits(lights={"sun": LightEdit(on=True, direction=(0.0, -1.0, 0.4), color=(1.0, 0.5, 0.2))}),
        SceneEdits(lights={"sun": LightEdit(on=False)}),
    ]
)
@given(st.lists(EDITS, min_size=1, max_size=3))
@settings(max_examples=2, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck))
def test_edits_leave_nothing_of_what_was_before(method: Method, steps: list[SceneEdits]) -> None:
    general = method in (Method.EXACT_VPL, Method.PHOTON_GATHER)  # they would compile some for these edits alone
    base, options = room().generalised(general=general), RenderSettings(**COUNTS, method=method)
    loaded, state = LoadedScene(SceneRef("room", "room"), base.scene, base, LightSets(base), base.scene), None
    for step in steps:
        before, state = state, edit(loaded, step, state)
        if state is not before:
            renderer = Renderer(state.device_scene, SIZE, options, light_sets=state.light_sets)
        found = renderer.render(CAMERA)
        anew = DeviceScene(edited(base.scene, step), "cpu").generalised(general=general)
        assert found.radiance().tobytes() == Renderer(anew, SIZE, options).render(CAMERA).radiance().tobytes()


def test_edits_leave_nothing_of_portals_that_were() -> None:
    """A bulb next door, whose light comes by a slit, goes in and out of view; so does the slit."""
    wall = replace(quad((0.1, -0.5, -0.5), (0.0, 0.0, 0.96), (0.0, 1.0, 0.0), 1), name="wall")
    bulb = Light("bulb", LightKind.POINT, (0.1, 0.2, 0.1), (0.3, 0.3, 0.0))
    camera = look_at((-0.1, 0.0, 0.3), (-0.1, 0.0, -0.3))
    scene = replace(scene_of([*box(), wall], [grey(0.7), grey(0.6)], lights=[bulb]), cameras=(camera,))
    base, options = DeviceScene(scene, "cpu").generalised(), RenderSettings(**COUNTS | {"vpls": 2000})
    steps = [
        SceneEdits(lights={"bulb": LightEdit(position=(0.3, -0.2, 0.2))}),
        SceneEdits(lights={"bulb": LightEdit(position=(-0.3, -0.2, 0.2))}),
        SceneEdits(materials={"default": MaterialEdit(color=(0.9, 0.2, 0.2))}),
        SceneEdits(objects={"wall": ObjectEdit(visible=False)}),
        SceneEdits(lights={"bulb": LightEdit(intensity=2.0)}),
    ]
    loaded, state, portals = LoadedScene(SceneRef("room", "room"), scene, base, LightSets(base), scene), None, []
    for step in steps:
        before, state = state, edit(loaded, step, state)
        if state is not before:
            renderer = Renderer(state.device_scene, SIZE, options, light_sets=state.light_sets)
        found = renderer.render(camera).radiance().tobytes()
        anew = DeviceScene(edited(scene, step), "cpu").generalised()
        assert found == Renderer(anew, SIZE, options).render(camera).radiance().tobytes()
        portals += [plan.portals is not None for plan in state.light_sets._paths.values()]
    assert portals == [True, False, True, False, True]


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.RSM_DISKS, Method.PHOTON_GATHER])
def test_a_walk_keeps_nothing_of_the_light_before_but_where_things_are(method: Method) -> None:
    """Its clusters stay in place, so that they do not flicker while somebody drags a light."""
    base, options = room(), RenderSettings(**COUNTS, method=method)
    bulb = LightEdit(position=(0.1, -0.1, 0.2), intensity=3.0, color=(1.0, 0.4, 0.1))
    wanted = SceneEdits(lights={"bulb": bulb, "sky": LightEdit(intensity=0.5)})

    def walked(*edits: SceneEdits) -> bytes:
        now = base.edited(edited(base.scene, edits[0]))
        sets = LightSets(now)
        renderer = Renderer(now, SIZE, options, light_sets=sets)
        for number, step in enumerate(edits):
            assert number == 0 or sets.follow(base.edited(edited(base.scene, step)))
            picture = renderer.render(rotated(CAMERA, 0.3 * number), walks=True).radiance().tobytes()
        return picture

    dim, moved = LightEdit(intensity=0.2), LightEdit(position=(-0.3, 0.2, 0.1))
    before = SceneEdits(lights={"bulb": dim, "default": dim}), SceneEdits(lights={"bulb": moved})
    first, second = (walked(edits, wanted) for edits in before)
    assert first == second
    alone = Renderer(base.edited(edited(base.scene, wanted)), SIZE, options).render(rotated(CAMERA, 0.3))
    assert first != alone.radiance().tobytes()


@pytest.mark.parametrize("method", [Method.EXACT_VPL, Method.FUZZY_VPL])
def test_a_light_that_is_dimmed_counts_by_what_it_is_dimmed_to(method: Method) -> None:
    """Indirect light of two lights is that of each alone, summed, by all that does not ask how bright something is."""
    skip = Skips(shared_weak_rays=False, far_field_sums=False)
    once = {"correct": False, "smooth": False, "component": Component.INDIRECT, "skip": skip}
    base, options = DeviceScene(replace(room().scene, sky=None), "cpu"), RenderSettings(**COUNTS, **once, method=method)
    now = base.edited(base.scene)
    sets = LightSets(now)
    renderer = Renderer(now, SIZE, options, light_sets=sets)

    def lit(**factors: float) -> Doubles:
        lights = {one: LightEdit(intensity=factor) for one, factor in factors.items()}
        assert sets.follow(base.edited(edited(base.scene, SceneEdits(lights=lights))))
        return np.asarray(renderer.render(CAMERA).radiance(), np.float64)

    lamp, bulb, mixed = lit(bulb=0.0), lit(default=0.0), lit(default=0.5, bulb=2.0)
    assert min(lamp.mean(), bulb.mean()) > 0.05 * mixed.mean()
    assert np.abs(mixed - (0.5 * lamp + 2.0 * bulb)).max() < 1e-5 * mixed.max()


# On CUDA what is made so often is a graph's at last.
CHANGES = [
    *(SceneEdits(lights={"bulb": LightEdit(position=(0.1 * step, 0.0, 0.2))}) for step in range(5)),
    *(SceneEdits(lights={"bulb": LightEdit(intensity=0.5 * step)}) for step in range(4)),
    *(SceneEdits(objects={"block": ObjectEdit(offset=(0.03 * step, 0.0, -0.1))}) for step in range(5)),
    *(SceneEdits(materials={"default": MaterialEdit(color=(0.2 * step, 0.1, 1.0))}) for step in range(4)),
]


def walk(size: tuple[int, int], device: str, **counts: int) -> list[tuple[bytes, list[str]]]:
    """Frames of a walk and their stages, each after one of CHANGES; of another walk, where that needs other arrays."""
    base, options = room(device).generalised(general=False), RenderSettings(**counts)
    loaded, state = LoadedScene(SceneRef("room", "room"), base.scene, base, LightSets(base), base.scene), None
    frames = []
    for number, step in enumerate(CHANGES):
        before, state = state, edit(loaded, step, state)
        if state is not before:
            renderer = Renderer(state.device_scene, size, options, light_sets=state.light_sets)
        frame = renderer.render(rotated(CAMERA, 0.3 * number), walks=True)
        frames.append((frame.radiance().tobytes(), list(frame.stats.stage_ms)))
    return frames


class LightFirst(Stages):
    """Runs stages that are beside others before these, not after them."""

    def start_frame(self) -> None:
        super().start_frame()
        self._later: list[Callable[[], None]] = []
        self._is_beside = False

    def _take(self, work: Callable[[], None]) -> None:
        if self._is_beside:
            work()
        else:
            self._later.append(work)

    def run(self, *stage: Any, **options: Any) -> None:
        self._take(partial(super().run, *stage, **options))

    def fork(self, *stage: Any, **options: Any) -> None:
        self._take(partial(super().fork, *stage, **options))

    def run_untimed(self, *stage: Any, **options: Any) -> None:
        self._take(partial(super().run_untimed, *stage, **options))

    def flush(self) -> None:
        later, self._later = ([], self._later) if self._is_beside else (self._later, [])
        for work in later:
            work()

    @contextmanager
    def beside(self) -> Iterator[None]:
        self._is_beside = True
        yield
        self._is_beside = False


def test_light_that_an_edit_changes_is_made_before_or_after_what_a_frame_begins_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    after = walk(SIZE, "cpu", **COUNTS)
    _, names = after[1]
    assert names == [*(name for name in FuzzyVpl.stage_names if name in names), "display"]
    assert names[:7] == ["gbuffer", "history", "cluster", "pilot", "light", "vpl-clusters", "radiosity"]
    monkeypatch.setattr("gpu.renderer.Stages", LightFirst)
    before = walk(SIZE, "cpu", **COUNTS)
    assert before[1][1][:5] == ["pilot", "light", "vpl-clusters", "radiosity", "gbuffer"]
    assert [radiance for radiance, _ in before] == [radiance for radiance, _ in after]


@NEEDS_CUDA
def test_light_that_is_made_beside_other_stages_has_the_bits_of_what_is_made_after_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fork = Stages.fork

    def frames() -> list[bytes]:
        return [radiance for radiance, _ in walk((1024, 576), "cuda:0")]

    def radiosity_first(stages: Stages, name: str, part: str, work: Callable[[], None], **options: Any) -> None:
        if part == "radiosity":
            stages.run(part, work)
        else:
            fork(stages, name, part, work, **options)

    beside = [frames() for _ in range(2)]
    monkeypatch.setattr(Stages, "fork", radiosity_first)
    assert beside[0] == frames()
    monkeypatch.setattr(Stages, "beside", lambda stages: nullcontext())
    assert beside == [frames()] * 2


def seen_room() -> DeviceScene:
    """A closed room with a bulb and a screen, a tenth of the scene's size, on a wide plain under a sky, which is seen
    by a camera inside; a slit lets light of a lamp in a room beside it in.
    """
    walls = [replace(part, positions=part.positions * 0.1) for part in box(0)]
    beside = [replace(part, positions=part.positions * 0.1 + np.float32([0.11, 0.0, 0.0])) for part in box(0)]
    slit = quad((0.05, -0.05, -0.05), (0.0, 0.0, 0.095), (0.0, 0.1, 0.0), 0)
    screen = replace(quad((-0.02, -0.05, -0.02), (0.04, 0.0, 0.0), (0.0, 0.04, 0.0), 1), name="block")
    plain = quad((-0.5, -0.06, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 0)
    bulb = Light("bulb", LightKind.POINT, (1e-4, 1e-4, 1e-4), (0.11, 0.0, 0.0))
    parts = [*walls[:1], *walls[2:], *beside[1:], slit, screen, plain]
    made = scene_of(parts, [grey(0.6), grey(0.4)], lights=[bulb], sky=Sky((1.0, 1.0, 1.0)))
    return DeviceScene(replace(made, cameras=(look_at((-0.04, 0.0, 0.02), (0.0, 0.0, -0.02)),)), "cpu")


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.RSM_DISKS])
def test_what_cameras_see_of_lights_follows_edits(method: Method) -> None:
    """Which lights are chosen, and which VPLs are kept, is as if the scene had been loaded so."""
    base, options = seen_room(), RenderSettings(**COUNTS, method=method)
    loaded, state = LoadedScene(SceneRef("room", "room"), base.scene, base, LightSets(base), base.scene), None
    for step in (
        SceneEdits(lights={"bulb": LightEdit(position=(0.1, 0.0, 0.0))}),
        SceneEdits(lights={"bulb": LightEdit(position=(0.0, 0.0, 0.0))}),
        SceneEdits(lights={"bulb": LightEdit(position=(0.0, 0.0, 0.0), intensity=30.0)}),
        SceneEdits(objects={"block": ObjectEdit(offset=(0.0, 0.05, -0.02))}),
    ):
        before, state = state, edit(loaded, step, state)
        if state is not before:
            renderer = Renderer(state.device_scene, SIZE, options, light_sets=state.light_sets)
        found = renderer.render(base.scene.cameras[0])
        anew = Renderer(DeviceScene(edited(base.scene, step), "cpu"), SIZE, options)
        assert found.radiance().tobytes() == anew.render(base.scene.cameras[0]).radiance().tobytes()
