"""The real renderer behind the border, tiny and on the CPU; and once through the whole service."""

import io
import weakref
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from harness import IDENTITY, run
from PIL import Image

from gpu.errors import UserError
from gpu.scene import load_scene
from gpu.settings import RenderSettings
from server.backend import GpuBackend, view_camera
from server.engine import WORKER
from server.messages import LookAt, Output, Placed, Render, SceneCamera, SceneRef, Start, View
from server.settings import ServerSettings

BOX, TWIN, THIRD = (SceneRef(name, "cornell-box") for name in ("box", "twin", "third"))
SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)


def silent(_: str, __: float) -> None:
    pass


def job(
    viewer: int = 1,
    scene: SceneRef = BOX,
    view: View = SceneCamera(0),  # noqa: B008
    size: tuple[int, int] = (32, 18),
    settings: RenderSettings = SETTINGS,
    output: Output = "jpeg",
) -> Render:
    return Render(viewer, scene, view, size, settings, output)


@pytest.fixture(scope="module")
def started(cpu: str) -> GpuBackend:
    backend = GpuBackend()
    assert backend.start(Start(BOX, cpu, max_scenes=2), silent) == cpu
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
    backend.render(job(view=Placed((*IDENTITY[:12], 0.0, 100.0, 0.0, 1.0), 1.0)), silent)
    np.testing.assert_array_equal(picture.pixels, before)


def test_a_viewers_renderer_is_kept_while_nothing_about_it_changes(backend: GpuBackend) -> None:
    backend.render(job(), silent)
    first = backend._seats[1].renderer
    backend.render(job(view=LookAt((0.5, 0.5, 3.0), (0.5, 0.5, 0.0), (0.0, 1.0, 0.0), 40.0)), silent)
    assert backend._seats[1].renderer is first
    backend.render(job(size=(18, 32)), silent)
    assert backend._seats[1].renderer is not first


def test_a_viewer_that_leaves_frees_its_renderer(backend: GpuBackend) -> None:
    backend.render(job(), silent)
    renderer = weakref.ref(backend._seats[1].renderer)
    backend.leave(1)
    assert renderer() is None


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


def test_an_error_of_a_scene_names_its_id_not_its_path(backend: GpuBackend, tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(b"no GLB")
    with pytest.raises(UserError, match=r"^hall\.glb: ") as caught:
        backend.open(SceneRef("hall.glb", str(tmp_path / "secret.glb")), silent)
    assert str(tmp_path) not in str(caught.value)


@pytest.mark.parametrize("camera", [99, "nowhere"])
def test_a_camera_that_is_not_there_is_refused_with_those_that_are(backend: GpuBackend, camera: int | str) -> None:
    with pytest.raises(UserError, match=rf"no camera {camera!r}; it has 0 \("):
        backend.render(job(view=SceneCamera(camera)), silent)


def test_views_become_cameras() -> None:
    scene = load_scene("cornell-box")
    by_index, by_name = (view_camera(scene, SceneCamera(key), (40, 10)) for key in (0, scene.cameras[0].name))
    assert by_index.aspect == 4.0
    np.testing.assert_array_equal(by_index.to_world, by_name.to_world)
    placed = view_camera(scene, Placed((*IDENTITY[:12], 1.0, 2.0, 3.0, 1.0), np.pi / 2), (10, 10))
    np.testing.assert_array_equal(placed.to_world[:3, 3], (1.0, 2.0, 3.0))
    assert placed.half_height == pytest.approx(1.0)
    looking = view_camera(scene, LookAt((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0), (10, 10))
    np.testing.assert_allclose(looking.to_world[:3, 3], (0.0, 0.0, 5.0))
    assert looking.half_height == pytest.approx(1.0)


def test_the_whole_way_from_a_pose_to_a_lit_frame(cpu: str) -> None:
    with run(ServerSettings(port=0, device=cpu), WORKER) as service, service.walker() as walker:
        service.wait_ready(280)
        still = service.http.post("/api/v1/render", json={"size": [64, 36], "settings": SETTINGS.model_dump()})
        assert still.status_code == 200, still.text
        expected = np.asarray(Image.open(io.BytesIO(still.content)), int)
        assert expected.std() > 10.0
        scene = walker.hello(size=[64, 36], settings=SETTINGS.model_dump())
        camera = scene["cameras"][0]
        walker.send("pose", id=1, matrix=camera["matrix"], yfov=camera["yfov"])
        header, image = walker.frame(60)
        assert header.pose == 1
        assert sum(header.stages) > 0.0
        # The same view by both ways, but for the loss of the JPEG.
        assert np.abs(simplejpeg.decode_jpeg(image).astype(int) - expected).mean() < 8.0
