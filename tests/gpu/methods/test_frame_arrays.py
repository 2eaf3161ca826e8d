from frame_view import FrameView
from scenes import box, grey, quad, resident_of

from gpu.device_scene.data import NO_HIT
from gpu.scene.camera import look_at

SIZE = (12, 8)


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
