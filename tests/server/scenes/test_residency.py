import asyncio
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from engines import BOX, FakeEngine
from harness import ANY_CHECK, PATIENCE

from gpu.errors import SceneError
from gpu.scene.import_options import ImportOptions
from server.places import asker
from server.refusals import NoRoomError
from server.render.activity import Activity, EngineState
from server.render.engine_pool import EnginePool
from server.scenes.checked import Checked, SceneSize
from server.scenes.checker import CHECK, Checker
from server.scenes.residency import LIGHTING_BYTES, MOST_READINGS, Residency, device_bytes
from server.settings import ServerSettings
from server.wire.worker import CloseScene, OpenScene, SceneRef

MEGABYTE = 10**6

# Prints the expected bytes of a scene, and by how much the process grew when it was put on the CPU and rendered. A
# small scene goes before, so that what every first scene takes is not counted.
MEASURED = """
import gc, sys
from pathlib import Path
sys.path[:0] = sys.argv[1:]
from gpu.renderer import Renderer
from gpu.device_scene.upload import DeviceScene
from gpu.settings import RenderSettings
from server.scenes.check_scene import measure
from server.scenes.residency import device_bytes
from tests.bench.hall import make_hall

def resident(triangles):
    scene = make_hall(triangles)
    renderer = Renderer(DeviceScene(scene, "cpu"), (64, 36), RenderSettings(lambertian=True))
    renderer.render(scene.cameras[0])
    gc.collect()
    return scene, renderer, int(Path("/proc/self/statm").read_text().split()[1]) * 4096

first = resident(1000)
scene, renderer, used = resident(300_000)
print(device_bytes(measure(scene)), used - first[2])
"""


def residency(
    *engines: FakeEngine, check: Sequence[str] = ANY_CHECK, reserve_bytes: int = 0, used: Sequence[SceneRef] = ()
) -> Residency:
    checker = Checker(ServerSettings(), check)
    return Residency(EnginePool(engines), checker, reserve_bytes, lambda: used, lambda _: None, lambda *_: None)


@pytest.fixture
def hall(tmp_path: Path) -> SceneRef:
    """A scene file of some size."""
    rows = [f"v {x} {x % 7} {x % 11}" for x in range(3000)] + [f"f {x} {x + 1} {x + 2}" for x in range(1, 2990)]
    (tmp_path / "hall.obj").write_text("\n".join(rows))
    return SceneRef("hall.obj", str(tmp_path / "hall.obj"), 1)


def test_more_of_anything_is_expected_to_take_more() -> None:
    small = SceneSize(vertices=100, triangles=100, uv_sets=0, colored=False, materials=1, texels=0)
    for change in ({"vertices": 200}, {"triangles": 200}, {"uv_sets": 1}, {"colored": True}, {"texels": 100}):
        assert device_bytes(small.model_copy(update=change)) > device_bytes(small)


def test_the_expected_bytes_are_those_taken_within_a_factor_of_two() -> None:
    command = [sys.executable, "-c", MEASURED, str(Path(__file__).parents[3])]
    done = subprocess.run(command, capture_output=True, timeout=200, check=True)
    expected, taken = (int(word) for word in done.stdout.split()[-2:])
    assert expected / 2 < taken < expected * 2


def test_a_scene_is_read_and_loaded_once(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine)

    async def run() -> None:
        assert scenes.bytes_of(hall) is None
        infos = await asyncio.gather(*(scenes.open(hall) for _ in range(3)))
        assert {info.id for info in infos} == {"hall.obj"}
        assert not scenes.opening(hall.id)
        assert not scenes._opening  # of uploads there is no end
        assert engine.opened == [hall]
        assert (scenes.bytes_of(hall) or 0) > LIGHTING_BYTES

    asyncio.run(run())


def test_what_is_in_a_scene_is_told_to_all_who_come_for_it(hall: SceneRef) -> None:
    told: list[SceneRef] = []
    scenes = Residency(
        EnginePool([FakeEngine()]),
        Checker(ServerSettings(), ANY_CHECK),
        reserve_bytes=0,
        used=tuple,
        touch=lambda _: None,
        learned=lambda scene, _: told.append(scene),
    )

    async def run() -> None:
        for _ in range(2):  # of its file as it was, somebody may have edits since
            await scenes.open(hall)

    asyncio.run(run())
    assert told == [hall, hall]


def test_the_worker_is_given_what_was_checked_once(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine, check=CHECK)

    async def run() -> None:
        await scenes.open(hall)
        engine.scenes = ()
        await scenes.open(hall)

    asyncio.run(run())
    opened = [job for _, _, job in engine.orders if isinstance(job, OpenScene)]
    assert [bool(job.packed) for job in opened] == [True, False]


def test_a_scene_that_left_the_device_is_loaded_again(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine)

    async def run() -> None:
        await scenes.open(hall)
        engine.scenes = ()
        await scenes.open(hall)
        assert engine.opened == [hall, hall]

    asyncio.run(run())


def test_a_file_that_changed_is_read_again(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine, check=CHECK)

    async def run() -> None:
        await scenes.open(hall)
        Path(hall.source).write_text("v 0 0")
        with pytest.raises(SceneError, match=r"hall\.obj: line 1"):
            await scenes.open(SceneRef(hall.id, hall.source, 2))

    asyncio.run(run())


def test_what_a_file_was_is_freed_once_nobody_looks_at_it(hall: SceneRef) -> None:
    engine, used = FakeEngine(), list[SceneRef]()
    scenes = residency(engine, used=used)
    inches = replace(hall, options=ImportOptions(unit="in"))

    async def run() -> list[SceneRef]:
        await scenes.open(inches)
        for stamp in range(1, 5):
            newest = replace(hall, stamp=stamp)
            await scenes.open(newest)
            used[:] = [newest]
        return [job.scene for _, _, job in engine.orders if isinstance(job, CloseScene)]

    assert asyncio.run(run()) == [inches, *(replace(hall, stamp=stamp) for stamp in (1, 2))]


def test_what_does_not_fit_is_not_tried(hall: SceneRef) -> None:
    engine = FakeEngine()
    viewed, idle = SceneRef("viewed.glb", "viewed.glb"), SceneRef("idle.glb", "idle.glb")
    scenes = residency(engine, reserve_bytes=100 * MEGABYTE, used=[SceneRef("viewed.glb", "")])

    async def run() -> None:
        engine.scenes = (viewed, idle)
        engine.memory = (840 * MEGABYTE, 1000 * MEGABYTE)
        with pytest.raises(NoRoomError) as caught:
            await scenes.open(hall)
        assert str(caught.value) == (
            "hall.obj: needs about 67 MB on the device, which has 60 MB to give (100 MB of it stay free); "
            "unload what nobody looks at: idle.glb"
        )
        assert engine.opened == []
        engine.memory = (820 * MEGABYTE, 1000 * MEGABYTE)
        await scenes.open(hall)

    asyncio.run(run())


def test_built_in_scenes_are_not_read_first() -> None:
    engine = FakeEngine()
    scenes = residency(engine, check=("false",))
    asyncio.run(scenes.open(BOX))
    assert engine.opened == [BOX]


def test_who_comes_at_the_same_time_waits_for_one_reading(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine)

    async def run() -> None:
        infos = await asyncio.gather(*(scenes.open(hall) for _ in range(40)))
        assert all(info == infos[0] for info in infos)
        assert scenes._checker.outcomes.total() == 1

    asyncio.run(run())


def test_what_is_there_waits_for_no_loading_and_others_come_before_a_clients_second() -> None:
    engine = FakeEngine()
    scenes = residency(engine)
    slow, more, other = (SceneRef(name, "cornell-box") for name in ("slow", "more", "other"))

    async def ask(client: str, scene: SceneRef) -> None:
        asker.set(client)
        await scenes.open(scene)

    async def run() -> None:
        await scenes.open(BOX)
        engine.gate = asyncio.Event()
        wanted = [("a", slow), ("a", more), ("b", other)]
        asked = [asyncio.create_task(ask(client, scene)) for client, scene in wanted]
        await asyncio.sleep(0)
        async with asyncio.timeout(PATIENCE):
            await scenes.open(BOX)
            engine.gate.set()
            await asyncio.gather(*asked)
        assert engine.opened == [BOX, slow, other, more]

    asyncio.run(run())


def test_of_one_client_one_scene_is_read_at_a_time_and_nobody_waits_for_it(
    hall: SceneRef, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes, began, gate = residency(FakeEngine()), list[str](), asyncio.Event()
    check = scenes._checker.check

    async def slowly(source: str, name: str, **more: Any) -> Checked:
        began.append(name)
        if name != "c":
            await gate.wait()
        return await check(source, name, **more)

    async def ask(client: str, name: str) -> None:
        asker.set(client)
        await scenes.inspect(replace(hall, id=name))

    async def run() -> None:
        asked = [asyncio.create_task(ask("a", name)) for name in "abc"]
        await asyncio.sleep(0)
        async with asyncio.timeout(PATIENCE):
            await asyncio.create_task(ask("b", "c"))
            assert began == ["a", "c"]
            gate.set()
            await asyncio.gather(*asked)

    monkeypatch.setattr(scenes._checker, "check", slowly)
    asyncio.run(run())


def test_what_was_in_a_lost_file_is_forgotten(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine)

    async def run() -> None:
        await scenes.inspect(hall)
        assert scenes.bytes_of(hall) is not None
        Path(hall.source).unlink()
        await scenes.free_lost()
        assert scenes.bytes_of(hall) is None

    asyncio.run(run())


def test_a_file_read_otherwise_is_read_and_loaded_beside_itself(hall: SceneRef) -> None:
    engine = FakeEngine()
    scenes = residency(engine, check=CHECK)
    inches = replace(hall, options=ImportOptions(unit="in"))

    async def run() -> None:
        plain, turned = await scenes.inspect(hall), await scenes.inspect(inches)
        assert (plain.info.frame.metres_per_unit, turned.info.frame.metres_per_unit) == (1.0, 0.0254)
        assert turned.info.options == inches.options
        await scenes.open(hall)
        await scenes.open(inches)
        assert engine.opened == [hall, inches]
        assert scenes.holds(hall)

    asyncio.run(run())


def test_few_ways_to_read_a_file_are_remembered(hall: SceneRef) -> None:
    scenes = residency(FakeEngine())
    size = SceneSize(vertices=1, triangles=1, uv_sets=0, colored=False, materials=1, texels=0)
    checked = Checked.model_construct(source=hall.source, size=size)
    readings = [replace(hall, options=ImportOptions(origin=(float(x), 0.0, 0.0))) for x in range(MOST_READINGS + 3)]
    for reading in readings:
        scenes.learn(reading, checked)
    assert [scenes.bytes_of(reading) is not None for reading in readings] == [False] * 3 + [True] * MOST_READINGS
    scenes.learn(replace(hall, stamp=2), checked)
    assert scenes.bytes_of(readings[-1]) is None


def test_a_scene_is_loaded_by_the_worker_of_who_wants_it_and_freed_on_all(hall: SceneRef) -> None:
    first, second = FakeEngine(), FakeEngine()
    scenes = residency(first, second)

    async def run() -> None:
        infos = [await scenes.open(hall, client) for client in range(1, 8)]
        assert all(info == infos[0] for info in infos)
        assert (first.opened, second.opened) == ([hall], [hall])
        assert scenes._checker.outcomes.total() == 1
        await scenes.close(hall)
        assert (first.scenes, second.scenes) == ((), ())

    asyncio.run(run())


def test_a_scene_goes_to_the_worker_that_has_room_for_it(hall: SceneRef) -> None:
    full, free = FakeEngine(), FakeEngine()
    scenes = residency(full, free)

    async def run() -> None:
        for engine in (full, free):
            engine.set_activity(Activity(EngineState.READY))
        full.memory, free.memory = (990 * MEGABYTE, 1000 * MEGABYTE), (10 * MEGABYTE, 1000 * MEGABYTE)
        await scenes.open(hall, 1)
        assert (full.opened, free.opened) == ([], [hall])

    asyncio.run(run())
