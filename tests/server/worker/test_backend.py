"""The real renderer behind the border, tiny and on the CPU; and once through the whole service."""

import gc
import io
import weakref
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
import simplejpeg
from glb_file import TRIANGLE_GLB
from harness import IDENTITY, run
from PIL import Image

import server.worker.backend
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.upload import DeviceScene
from gpu.errors import OutOfMemoryError, UserError
from gpu.renderer import Renderer
from gpu.scene.edits import NO_EDITS, LightEdit, MaterialEdit, ObjectEdit, SceneEdits
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.load import load_scene
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings
from server.render.worker_process import WORKER
from server.settings import ServerSettings
from server.wire.worker import (
    CameraMatrix,
    CameraSpec,
    Export,
    LookAt,
    Output,
    Pick,
    Render,
    SceneCamera,
    SceneRef,
    Start,
)
from server.worker.backend import GpuBackend
from server.worker.tasks import Tasks

BOX, TWIN, THIRD = (SceneRef(name, "cornell-box") for name in ("box", "twin", "third"))
SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)
LEAST_SLICES = {Method.EXACT_VPL: 20, Method.PATH: 4, Method.FUZZY_VPL: 30}


def silent(_: str, __: float) -> None:
    pass


def job(
    viewer: int = 1,
    scene: SceneRef = BOX,
    view: CameraSpec = SceneCamera(0),  # noqa: B008
    size: tuple[int, int] = (32, 18),
    settings: RenderSettings = SETTINGS,
    output: Output = "jpeg",
) -> Render:
    return Render(viewer, scene, view, size, settings, output)


@pytest.fixture(scope="module")
def started(cpu: str) -> GpuBackend:
    backend = GpuBackend()
    assert backend.start(Start(BOX, cpu, max_scenes=2), silent, Tasks()) == cpu
    return backend


@pytest.fixture
def backend(started: GpuBackend) -> GpuBackend:
    for viewer in range(4):
        started.leave(viewer)
    return started


def test_a_picture_is_for_display_or_linear(backend: GpuBackend) -> None:
    shown = backend.render(job(), silent)
    assert shown.radiance is None
    assert shown.pixels is not None
    assert (shown.pixels.shape, shown.pixels.dtype) == ((18, 32, 3), np.uint8)
    linear = backend.render(job(output=".exr"), silent)
    assert linear.pixels is None
    assert linear.radiance is not None
    assert (linear.radiance.shape, linear.radiance.dtype) == ((18, 32, 3), np.float32)
    assert linear.counts["pixels"] == 32 * 18
    assert linear.counts["nonfinite"] == 0


def test_a_picture_is_not_overwritten_by_the_next_one(backend: GpuBackend) -> None:
    picture = backend.render(job(), silent)
    assert picture.pixels is not None
    before = picture.pixels.copy()
    backend.render(job(view=CameraMatrix((*IDENTITY[:12], 0.0, 100.0, 0.0, 1.0), 1.0)), silent)
    np.testing.assert_array_equal(picture.pixels, before)


def test_viewers_of_one_view_share_a_renderer(backend: GpuBackend) -> None:
    backend.render(job(viewer=1), silent)
    one = len(backend._renderers)
    backend.render(job(viewer=2, view=LookAt((0.5, 0.5, 3.0), (0.5, 0.5, 0.0), (0.0, 1.0, 0.0), 40.0)), silent)
    assert len(backend._renderers) == one
    backend.render(job(viewer=1, size=(18, 32)), silent)
    assert len(backend._renderers) == one + 1


def linear(backend: GpuBackend, viewer: int, sample: int | None, **rest: Any) -> tuple[int, Floats]:
    picture = backend.render(replace(job(viewer=viewer, output=".npy", **rest), sample=sample), silent)
    assert picture.radiance is not None
    return picture.samples, picture.radiance


def test_what_is_kept_for_a_viewer_goes_with_it(backend: GpuBackend) -> None:
    """Views are the viewer's own, whether it walks or rests; the renderer stays for those who come next."""
    backend.render(replace(job(viewer=1), walks=True), silent)
    linear(backend, 1, 0)
    linear(backend, 2, 0)
    (entry,) = [entry for key, entry in backend._renderers._entries.items() if key.size == (32, 18)]
    view, mean = weakref.ref(entry.views[1]), weakref.ref(backend._stills[1].accumulation)
    backend.leave(1)
    gc.collect()
    assert (view(), mean()) == (None, None)
    assert [*entry.views] == [*backend._stills] == [2]


def test_only_a_walk_builds_on_the_frame_before(backend: GpuBackend) -> None:
    views = [CameraMatrix((*IDENTITY[:12], 0.5 + 0.02 * number, 0.5, 3.0, 1.0), 0.7) for number in range(3)]
    single = linear(backend, 1, None, view=views[2])[1]
    kept = []
    for view in views:
        picture = backend.render(replace(job(view=view, output=".npy"), walks=True), silent)
        kept.append(picture.skips["kept_clusters"] > 0)
    assert kept == [True, True, True]  # the first goes on from the single one
    assert linear(backend, 1, None, view=views[2])[1].tobytes() == single.tobytes()
    assert linear(backend, 1, 0, view=views[2])[1].tobytes() == single.tobytes()


def test_a_view_that_rests_begins_with_what_its_walk_showed(backend: GpuBackend) -> None:
    views = [CameraMatrix((*IDENTITY[:12], 0.5 + 0.02 * number, 0.5, 3.0, 1.0), 0.7) for number in range(3)]
    for view in views:
        moving = backend.render(replace(job(view=view, output=".npy"), walks=True), silent)
    assert moving.radiance is not None
    first = backend.render(replace(job(view=views[2], output=".npy"), walks=True, sample=0), silent)
    assert first.radiance is not None
    assert first.radiance.tobytes() == moving.radiance.tobytes()
    samples, mean = linear(backend, 1, 1, view=views[2])
    assert samples == 2
    assert np.abs(mean - moving.radiance).max() > 0.0


def test_two_walkers_see_what_each_sees_alone(backend: GpuBackend) -> None:
    def walk(viewer: int, z: float) -> list[bytes]:
        return [frame(viewer, z, number) for number in range(3)]

    def frame(viewer: int, z: float, number: int) -> bytes:
        view = CameraMatrix((*IDENTITY[:12], 0.5 + 0.02 * number, 0.5, z, 1.0), 0.7)
        picture = backend.render(replace(job(viewer=viewer, view=view, output=".npy"), walks=True), silent)
        assert picture.radiance is not None
        assert number == 0 or picture.skips["kept_clusters"] > 0
        return picture.radiance.tobytes()

    alone = [walk(1, 3.0), walk(2, 0.9)]
    for viewer in (1, 2):
        backend.leave(viewer)
    together = [(frame(1, 3.0, number), frame(2, 0.9, number)) for number in range(3)]
    assert [list(frames) for frames in zip(*together, strict=True)] == alone


@pytest.mark.parametrize("method", [Method.EXACT_VPL, Method.PATH, Method.FUZZY_VPL])
def test_pictures_are_the_same_whoever_interrupts_them(
    backend: GpuBackend, method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A walker gets a frame at each pause of another's picture, and each waits for no more than some slices."""
    settings = SETTINGS.model_copy(update={"method": method, "samples": 2})
    heavy, light = job(viewer=1, settings=settings, output=".npy", size=(96, 64)), job(viewer=2, output=".npy")
    alone = [backend.render(one, silent).radiance for one in (heavy, light)]
    backend.leave(1)
    backend.leave(2)
    frames: list[Floats | None] = []
    tasks = Tasks()
    pictures: list[Floats | None] = []
    monkeypatch.setattr(tasks, "due", lambda: tasks._current is not None and tasks._current.request == 1)
    DEVICE_SHARING.begin(tasks)
    try:
        tasks.start(1, lambda: pictures.append(backend.render(heavy, silent).radiance))
        for request in count(2):
            tasks.start(request, lambda: frames.append(backend.render(light, silent).radiance))
            for one in range(1, request + 1):  # a walker may wait for what both need
                if tasks.knows(one):
                    tasks.resume(one)
            if not tasks.knows(1):
                break
    finally:
        DEVICE_SHARING.begin(None)
    assert len(frames) >= LEAST_SLICES[method]
    for picture, expected in zip([*pictures, frames[-1]], alone, strict=True):
        assert picture is not None
        assert expected is not None
        assert picture.tobytes() == expected.tobytes()


def test_frames_of_a_still_view_are_averaged_for_each_viewer(backend: GpuBackend) -> None:
    single = linear(backend, 1, None)[1]
    first = linear(backend, 1, 0)
    other = linear(backend, 2, 0, view=CameraMatrix((*IDENTITY[:12], 0.5, 0.5, 3.0, 1.0), 0.7))
    second = linear(backend, 1, 1)
    assert (first[0], second[0], other[0]) == (1, 2, 1)
    assert first[1].tobytes() == single.tobytes()
    assert not np.array_equal(second[1], first[1])
    np.testing.assert_allclose(second[1].mean(), first[1].mean(), rtol=0.2)
    backend.leave(1)
    assert linear(backend, 1, 0)[1].tobytes() == first[1].tobytes()
    assert linear(backend, 1, 1)[1].tobytes() == second[1].tobytes()


@pytest.mark.parametrize(
    "change", [{"size": (16, 16)}, {"view": LookAt((0.5, 0.5, 2.0), (0.5, 0.5, 0), (0, 1, 0), 40)}]
)
def test_a_mean_that_is_not_of_this_view_begins_anew(backend: GpuBackend, change: dict[str, Any]) -> None:
    linear(backend, 1, 0)
    linear(backend, 1, 1)
    assert linear(backend, 1, 2, **change)[0] == 1
    assert linear(backend, 3, 5)[0] == 1


def test_a_frame_that_nobody_sees_is_not_copied(backend: GpuBackend) -> None:
    picture = backend.render(job(output="none"), silent)
    assert picture.pixels is None
    assert picture.radiance is None
    assert picture.target > 1


@pytest.mark.parametrize("failures", [1, 2])
def test_too_little_memory_is_met_by_making_room_and_then_by_an_error(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch, failures: int
) -> None:
    backend.render(job(viewer=1), silent)
    get, left = backend._renderers.get, [failures]

    def scarce(*arguments: Any) -> Renderer:
        if left[0]:
            left[0] -= 1
            raise RuntimeError("Failed to allocate 123 bytes on device 'cuda:0'")
        return get(*arguments)

    monkeypatch.setattr(backend._renderers, "get", scarce)
    if failures == 1:
        assert backend.render(job(viewer=2), silent).pixels is not None
    else:
        with pytest.raises(OutOfMemoryError, match="32×18 pixels"):
            backend.render(job(viewer=2), silent)
    monkeypatch.undo()
    assert backend.render(job(viewer=2), silent).pixels is not None


def test_a_scene_for_which_there_is_too_little_memory_is_refused(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none_left(*_: Any) -> DeviceScene:
        raise RuntimeError("Failed to allocate 123 bytes on device 'cuda:0'")

    monkeypatch.setattr("server.worker.loaded_scene.DeviceScene", none_left)
    backend.close(THIRD)
    with pytest.raises(OutOfMemoryError, match="too little memory for this scene"):
        backend.open(THIRD, silent)
    monkeypatch.undo()
    assert backend.open(THIRD, silent).id == THIRD.id


def test_a_scene_that_is_closed_is_freed(backend: GpuBackend) -> None:
    backend.render(job(viewer=1), silent)
    scene = weakref.ref(backend._scenes[BOX].device_scene)
    gc.disable()  # device memory must not wait for the collector
    try:
        backend.close(BOX)
        assert scene() is None
    finally:
        gc.enable()
    assert backend.render(job(viewer=1), silent).pixels is not None


def test_memory_is_of_this_process_and_machine(backend: GpuBackend) -> None:
    used, total = backend.memory()
    assert 1 << 20 < used < total


def test_the_scene_used_longest_ago_makes_room(backend: GpuBackend) -> None:
    backend.open(BOX, silent)
    backend.open(TWIN, silent)
    backend.open(BOX, silent)
    backend.open(THIRD, silent)
    assert list(backend._scenes) == [BOX, THIRD]


def test_a_scene_that_is_viewed_is_not_dropped(backend: GpuBackend) -> None:
    backend.render(job(viewer=1, scene=BOX), silent)
    backend.render(job(viewer=2, scene=TWIN), silent)
    with pytest.raises(UserError, match="2 scenes are being viewed"):
        backend.open(THIRD, silent)
    backend.leave(1)
    backend.open(THIRD, silent)
    assert list(backend._scenes) == [TWIN, THIRD]


def test_a_scene_tells_the_files_that_it_was_read_with(backend: GpuBackend, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = SceneRef("a.obj", str(tmp_path / "a.obj"))
    backend.open(scene, silent)
    assert backend.beside(scene) == {"a.mtl": 0}
    backend.close(scene)


def test_an_error_of_a_scene_names_its_id_not_its_path(backend: GpuBackend, tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(b"no GLB")
    with pytest.raises(UserError, match=r"^hall\.glb: ") as caught:
        backend.open(SceneRef("hall.glb", str(tmp_path / "secret.glb")), silent)
    assert str(tmp_path) not in str(caught.value)


def test_an_error_of_a_picture_names_its_scene_by_its_id(backend: GpuBackend, tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(TRIANGLE_GLB)
    hall = SceneRef("hall.glb", str(tmp_path / "secret.glb"))
    with pytest.raises(UserError, match=r"^camera: hall\.glb has no camera 'attic'"):
        backend.render(job(view=SceneCamera("attic"), scene=hall), silent)


@pytest.mark.parametrize("camera", [99, "nowhere"])
def test_a_camera_that_is_not_there_is_refused_with_those_that_are(backend: GpuBackend, camera: int | str) -> None:
    with pytest.raises(UserError, match=rf"no camera {camera!r}; it has 0 \("):
        backend.render(job(view=SceneCamera(camera)), silent)


def test_the_whole_way_from_a_pose_to_a_lit_frame(cpu: str) -> None:
    with run(ServerSettings(port=0, device=cpu), WORKER) as service, ExitStack() as stack:
        service.wait_ready(280)
        walker = stack.enter_context(service.walker())
        still = service.http.post("/api/v1/render", json={"size": [64, 36], "settings": SETTINGS.model_dump()})
        assert still.status_code == 200, still.text
        expected = np.asarray(Image.open(io.BytesIO(still.content)), int)
        assert expected.std() > 10.0
        scene = walker.hello(size=[64, 36], settings=SETTINGS.model_dump())
        camera = scene["cameras"][0]
        walker.send("pose", id=1, matrix=camera["matrix"], yfov=camera["yfov"])
        header, image = walker.frame(60)
        assert header.pose == 1
        assert sum(header.stage_ms.values()) > 0.0
        # The same view by both ways, but for the loss of the JPEG.
        assert np.abs(simplejpeg.decode_jpeg(image).astype(int) - expected).mean() < 8.0


def test_an_environment_is_around_every_scene(cpu: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the kernels that a start waits for, only that of one picture is compiled."""
    sky = tmp_path / "sky.hdr"
    sky.write_bytes(b"#?RADIANCE\n\n-Y 1 +X 2\n" + bytes((128, 64, 32, 129)) * 2)
    backend = GpuBackend()
    monkeypatch.setattr("server.worker.backend.warm_up_soon", lambda device_scene, settings: None)
    with monkeypatch.context() as started:
        started.setattr(backend, "render", lambda job, report: None)  # its first picture
        backend.start(Start(BOX, cpu, environment=EnvironmentOptions(environment=sky)), silent, Tasks())
    outside = LookAt((0.0, 1.0, 20.0), (0.0, 1.0, 40.0), None, 40.0)
    settings = RenderSettings(method=Method.PATH, component=Component.DIRECT, samples=1)
    seen = backend.render(job(view=outside, output=".exr", settings=settings), silent)
    assert seen.radiance is not None
    assert np.allclose(seen.radiance, [1.0, 0.5, 0.25])


def edited(backend: GpuBackend, edits: SceneEdits, **rest: Any) -> Floats:
    picture = backend.render(replace(job(output=".npy"), edits=edits, **rest), silent).radiance
    assert picture is not None
    return picture


def test_what_scenes_take_is_loaded_while_the_first_one_is_read(cpu: str, monkeypatch: pytest.MonkeyPatch) -> None:
    loading, read = Event(), load_scene

    def reading(*arguments: Any, **options: Any) -> Any:
        assert loading.wait(10.0)
        return read(*arguments, **options)

    monkeypatch.setattr(server.worker.backend, "load_kept_kernels", lambda device: loading.set())
    monkeypatch.setattr(server.worker.backend, "load_scene", reading)
    assert GpuBackend().start(Start(BOX, cpu), silent, Tasks()) == cpu


def test_a_picture_has_the_edits_of_its_job_whatever_came_before(backend: GpuBackend) -> None:
    dimmed, green = (
        SceneEdits(lights={"light": LightEdit(**change)}) for change in ({"intensity": 0.5}, {"color": (0.0, 1.0, 0.0)})
    )
    states = [dimmed, NO_EDITS, green, dimmed, green, NO_EDITS]
    shown = [edited(backend, edits) for edits in states]
    assert np.allclose(shown[0], 0.5 * shown[1], rtol=1e-3, atol=1e-5)
    assert (shown[2].max(axis=(0, 1)) > 0.0).tolist() == [False, True, False]
    for first, again in ((0, 3), (2, 4), (1, 5)):
        assert shown[first].tobytes() == shown[again].tobytes()


def test_a_mean_begins_anew_with_an_edit(backend: GpuBackend) -> None:
    off = SceneEdits(lights={"light": LightEdit(on=False)})
    for sample in range(2):
        edited(backend, NO_EDITS, sample=sample)
    assert not edited(backend, off, sample=2).any()
    assert backend.render(replace(job(), edits=off, sample=1), silent).samples == 2


def test_an_export_has_the_edits_of_its_job(
    backend: GpuBackend, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    red = SceneEdits(materials={"white": MaterialEdit(color=(1.0, 0.0, 0.0))})
    (tmp_path / "box.glb").write_bytes(backend.export(Export(BOX, red), silent))
    read = load_scene(str(tmp_path / "box.glb"))
    assert {it.name: it.base_color[:3] for it in read.materials}["white"] == (1.0, 0.0, 0.0)
    monkeypatch.setattr(server.worker.backend, "MAX_EXPORT_BYTES", 1000)
    with pytest.raises(UserError, match="box: as a GLB file has 0 MB, more than"):
        backend.export(Export(BOX), silent)


def test_a_pick_sees_the_scene_as_it_is_edited(backend: GpuBackend) -> None:
    there = Pick(BOX, SceneCamera(0), (40, 40), (0.5, 0.5))
    picked = backend.pick(there, silent)
    assert (picked.object, picked.material, picked.light) == ("white", "white", None)
    hidden = SceneEdits(objects={"white": ObjectEdit(visible=False)})
    assert backend.pick(replace(there, edits=hidden), silent).object is None


def test_a_scene_that_is_closed_leaves_no_state(backend: GpuBackend) -> None:
    edited(backend, SceneEdits(lights={"light": LightEdit(intensity=3.0)}))
    backend.close(BOX)
    assert len(backend._states) == 0
