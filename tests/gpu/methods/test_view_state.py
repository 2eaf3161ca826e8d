import numpy as np
import warp as wp
from frame_view import FrameView
from scenes import box, column, grey, quad, resident_of

from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData
from gpu.scene.camera import look_at

SIZE = (12, 8)


def test_the_camera_looks_with_the_aspect_of_the_image() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    view.set_camera(look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0), yfov_degrees=90.0, aspect=5.0))
    data = dict(zip(CameraData.vars, view.camera.numpy()[0], strict=True))
    assert np.isclose(data["half_height"], 1.0)
    assert np.isclose(data["half_width"], 1.5)


def test_another_camera_finds_other_shading_points() -> None:
    view = FrameView(resident_of([quad([-0.5, -0.5, 0], [1, 0, 0], [0, 1, 0])], [grey(0.5)]), SIZE, lambertian=True)
    counts = []
    for target in ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.0, 0.0)):
        view.set_camera(look_at((0.0, 0.0, 0.3), target, yfov_degrees=60.0))
        view.find_shading_points()
        counts.append(int(view.shading_points.count.numpy()[0]))
        pixels = view.shading_points.pixels.numpy()[: counts[-1]]
        assert (view.gbuffer.face.numpy()[pixels] != int(NO_HIT)).all()
    assert counts[:2] == [96, 0]
    assert 0 < counts[2] < 96


def test_lambertian_views_see_the_scene_as_the_references_do() -> None:
    device_scene = resident_of(box(), [grey(0.5)])
    assert FrameView(device_scene, SIZE, lambertian=True).scene.lambertian
    assert not FrameView(device_scene, SIZE, lambertian=False).scene.lambertian


def test_indirect_light_is_added_to_what_is_there() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    view.set_camera(look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0)))
    view.find_shading_points()
    direct, irradiance = np.random.default_rng(0).uniform(size=(2, 96, 3)).astype(np.float32)
    view.radiance.assign(column(direct, wp.vec3))
    view.indirect.irradiance.assign(column(irradiance, wp.vec3))
    view.shading_points.reflect(view.gbuffer, view.indirect.irradiance, view.brightness.value, view.radiance)
    assert np.allclose(view.radiance.numpy(), direct + 0.5 / np.pi * irradiance)


def test_a_view_with_a_stride_shades_fewer_points() -> None:
    device_scene = resident_of(box(), [grey(0.5)])
    counts = []
    for stride in (1, 2):
        view = FrameView(device_scene, SIZE, lambertian=True, stride=stride)
        view.set_camera(look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0)))
        view.find_shading_points()
        counts.append(int(view.shading_points.count.numpy()[0]))
    assert counts[0] == 96
    assert 24 <= counts[1] < 96


def test_light_ended_where_a_frame_of_the_walk_or_of_the_still_view_saw_it_end() -> None:
    view = FrameView(resident_of(box(), [grey(0.5)]), SIZE, lambertian=True)
    one, other = (look_at((0.0, 0.0, 0.4), (x, 0.0, 0.0)) for x in (0.0, 0.01))

    def follows(*args: object, **options: bool) -> bool:
        before = view.camera.numpy().tobytes()
        view.set_camera(*args, **options)
        assert view.shading_points.before.camera.numpy().tobytes() == before
        return bool(view.shading_points.before.follows.numpy()[0])

    assert not follows(one)
    assert not follows(one)  # again from nothing
    assert follows(one, 1)
    assert not follows(other, 1)
    view.wrote_history = True
    assert not follows(one)
    view.wrote_history = True
    assert follows(other, walks=True)
    assert not follows(one, walks=True)  # nothing was kept
