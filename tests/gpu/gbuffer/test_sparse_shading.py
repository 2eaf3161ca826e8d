import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column
from walls import CPU, HEIGHT, LEFT, WIDTH, grey_values, numbers, split_walls, wall

from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.sparse_shading import stride_of

STRIDE = 2
ROWS, COLUMNS = np.mgrid[0:HEIGHT, 0:WIDTH]
# Linear in both directions of the image.
SLOPE = 3.0 + 0.25 * COLUMNS + 0.5 * ROWS


def shaded(gbuffer: GBuffer, stride: int, **thresholds: float) -> NDArray:
    """Which pixels have SPs, (HEIGHT, WIDTH)."""
    sps = ShadingPoints((WIDTH, HEIGHT), stride, CPU, **thresholds)
    sps.find(gbuffer)
    chosen = np.zeros(WIDTH * HEIGHT, bool)
    chosen[sps.pixels.numpy()[: sps.count.numpy()[0]]] = True
    return chosen.reshape(HEIGHT, WIDTH)


def reflected(gbuffer: GBuffer, stride: int, irradiance: NDArray) -> NDArray:
    """Radiance of all pixels where those with SPs have `irradiance`, (HEIGHT, WIDTH)."""
    known = np.where(shaded(gbuffer, stride), irradiance, 1.0e9)
    radiance = wp.zeros(WIDTH * HEIGHT, dtype=wp.vec3, device=CPU)
    sps = ShadingPoints((WIDTH, HEIGHT), stride, CPU)
    sps.find(gbuffer)
    sps.reflect(gbuffer, grey_values(known), column([0.0], float), radiance)
    return numbers(radiance)


def test_on_a_plane_only_anchors_and_pixels_beyond_the_last_of_them_are_shaded() -> None:
    anchors = (ROWS % STRIDE == 0) & (COLUMNS % STRIDE == 0)
    beyond = (ROWS + STRIDE > HEIGHT) | (COLUMNS + STRIDE > WIDTH)
    assert np.array_equal(shaded(wall(), STRIDE), anchors | beyond)


def test_with_a_stride_of_one_every_pixel_with_a_surface_is_shaded() -> None:
    seen = np.random.default_rng(0).uniform(size=(HEIGHT, WIDTH)) < 0.5
    assert np.array_equal(shaded(wall(seen=seen), 1), seen)


@pytest.mark.parametrize("stride", [1, STRIDE])
def test_a_slope_of_light_on_a_plane_is_reproduced(stride: int) -> None:
    assert reflected(wall(), stride, SLOPE) == pytest.approx(SLOPE / np.pi, rel=1e-5)


def test_every_pixel_reflects_by_its_own_albedo() -> None:
    gbuffer = wall()
    albedo = np.random.default_rng(1).uniform(0.1, 0.9, (HEIGHT, WIDTH))
    gbuffer.albedo = grey_values(albedo)
    gbuffer.throughput.fill_(0.5)
    assert reflected(gbuffer, STRIDE, SLOPE) == pytest.approx(0.5 * albedo * SLOPE / np.pi, rel=1e-5)


def test_light_is_added_and_pixels_without_a_surface_stay_as_they_are() -> None:
    radiance = wp.full(WIDTH * HEIGHT, wp.vec3(7.0, 7.0, 7.0), dtype=wp.vec3, device=CPU)
    sps = ShadingPoints((WIDTH, HEIGHT), STRIDE, CPU)
    sps.find(wall(seen=LEFT))
    sps.reflect(wall(seen=LEFT), grey_values(SLOPE), column([0.0], float), radiance)
    assert numbers(radiance) == pytest.approx(np.where(LEFT, 7.0 + SLOPE / np.pi, 7.0), rel=1e-5)


@pytest.mark.parametrize("kind", ["normals", "depth", "nothing"])
def test_pixels_beside_another_surface_are_shaded_and_take_none_of_its_light(kind: str) -> None:
    gbuffer = split_walls()[kind]
    # Columns 22 and 24 have anchors, on either side: column 23 cannot be told by them.
    assert shaded(gbuffer, STRIDE)[:, 23].all()
    light = np.where(LEFT, 1.0, 1000.0)
    radiance = reflected(gbuffer, STRIDE, light)
    assert radiance[LEFT] == pytest.approx(1.0 / np.pi)
    if kind != "nothing":
        assert radiance[~LEFT] == pytest.approx(1000.0 / np.pi)


@pytest.mark.parametrize("kind", ["normals", "depth"])
def test_what_only_one_pixel_shows_is_shaded(kind: str) -> None:
    odd = (ROWS == 11) & (COLUMNS == 17)
    gbuffer = (
        wall(normals=np.where(odd[..., None], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]))
        if kind == "normals"
        else wall(depth=np.where(odd, 1.0, 0.0))
    )
    assert np.array_equal(shaded(gbuffer, STRIDE), shaded(wall(), STRIDE) | odd)


@pytest.mark.parametrize(("depth", "is_shaded"), [(0.09, False), (0.15, True)])
def test_a_pixel_off_its_plane_by_a_tenth_of_a_spacing_is_of_another_surface(depth: float, is_shaded: bool) -> None:
    odd = (ROWS == 11) & (COLUMNS == 17)
    assert shaded(wall(depth=np.where(odd, depth, 0.0)), STRIDE)[11, 17] == is_shaded


def test_a_slanted_plane_and_a_gentle_curve_are_interpolated() -> None:
    slant = np.array([-0.6, 0.0, 0.8])
    gbuffer = wall(normals=np.broadcast_to(slant, (HEIGHT, WIDTH, 3)), depth=0.75 * COLUMNS)
    assert np.array_equal(shaded(gbuffer, STRIDE), shaded(wall(), STRIDE))
    turn = 0.01 * COLUMNS
    curve = np.stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)], axis=2)
    # A cylinder that is 100 pixels wide in radius, seen from its side.
    gbuffer = wall(normals=curve, depth=100.0 * np.cos(turn))
    gbuffer.position.assign(np.stack([100.0 * np.sin(turn), -ROWS.astype(float), 100.0 * np.cos(turn)], axis=2)
                            .reshape(-1, 3).astype(np.float32))  # fmt: skip
    assert np.array_equal(shaded(gbuffer, STRIDE), shaded(wall(), STRIDE))


def test_what_three_of_four_anchors_tell_is_their_light_alone() -> None:
    odd = (ROWS == 10) & (COLUMNS == 16)
    assert odd[::STRIDE, ::STRIDE].any()
    gbuffer = wall(normals=np.where(odd[..., None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    radiance = reflected(gbuffer, STRIDE, np.where(odd, 1000.0, 1.0))
    assert radiance == pytest.approx(np.where(odd, 1000.0, 1.0) / np.pi, rel=1e-5)


def test_only_large_pictures_are_interpolated() -> None:
    assert [stride_of(width * height) for width, height in ((240, 135), (320, 180), (1280, 720))] == [1, 2, 2]


def seen_flat() -> wp.array:
    """The camera that sees the wall as its pixels are."""
    camera = CameraData()
    camera.origin = wp.vec3(0.5 * WIDTH - 0.5, 0.5 - 0.5 * HEIGHT, 10.0)
    camera.right, camera.up, camera.back = wp.vec3(1.0, 0.0, 0.0), wp.vec3(0.0, 1.0, 0.0), wp.vec3(0.0, 0.0, 1.0)
    camera.half_width, camera.half_height = 0.5 * WIDTH, 0.5 * HEIGHT
    camera.x = camera.y = 0.5
    camera.orthographic = True
    return wp.array([camera], dtype=CameraData, device=CPU)


def shaded_next(
    light: NDArray, *, follows: bool = True, mean: float = 1.0, **thresholds: float
) -> tuple[NDArray, NDArray]:
    """Which pixels of a wall are shaded in a frame after one that found `light`, and what they reflect of it then."""
    sps = ShadingPoints((WIDTH, HEIGHT), STRIDE, CPU, **thresholds)
    radiance = wp.zeros(WIDTH * HEIGHT, dtype=wp.vec3, device=CPU)
    inputs = wall(), grey_values(light), column([mean], float), radiance
    sps.find(wall())
    sps.reflect(*inputs)
    wp.copy(sps.before.camera, seen_flat())
    sps.before.follows.fill_(int(follows))
    sps.find(wall())
    radiance.zero_()
    sps.reflect(*inputs)
    return sps.listed.numpy().reshape(HEIGHT, WIDTH) == 1, numbers(radiance)


@pytest.mark.parametrize(("bright", "is_edge"), [(0.28, False), (0.45, True)])
def test_light_has_no_edge_where_it_is_dark_for_the_picture(bright: float, is_edge: bool) -> None:
    """Differences of 0.08 and 0.14 of the picture's mean radiance."""
    assert shaded_next(np.where(LEFT, 0.02, bright))[0][:, 23].all() == is_edge


def test_where_light_ends_between_anchors_the_next_frame_shades() -> None:
    light = np.where(LEFT, 1.0, 10.0)
    listed, radiance = shaded_next(light)
    usual = shaded(wall(), STRIDE)
    assert listed[:, 23].all()  # the last one on the left, between anchors of either side
    assert np.array_equal(listed[:, :22], usual[:, :22])
    assert np.array_equal(listed[:, 24:], usual[:, 24:])
    assert radiance == pytest.approx(light / np.pi, rel=1e-5)
    assert not usual[1:-1:2, 23].any()


@pytest.mark.parametrize("kind", ["another view", "dark", "slope"])
def test_elsewhere_it_shades_no_more(kind: str) -> None:
    light = SLOPE if kind == "slope" else np.where(LEFT, 1.0, 10.0)
    listed, _ = shaded_next(light, follows=kind != "another view", mean=100.0 if kind == "dark" else 1.0)
    assert np.array_equal(listed, shaded(wall(), STRIDE))


def test_how_much_of_a_pixel_its_anchors_must_tell() -> None:
    # Of the anchors around an odd pixel, half are an anchor of the same row: in column 23, between the halves.
    gbuffer = split_walls()["normals"]
    halves = ROWS[:, 23] % STRIDE == 0
    assert shaded(gbuffer, STRIDE, min_weight=0.4)[:-1, 23].sum() == 0
    assert shaded(gbuffer, STRIDE)[halves, 23].all()


def test_how_deep_a_surface_may_be() -> None:
    odd = (ROWS == 11) & (COLUMNS == 17)
    deeper = wall(depth=np.where(odd, 0.15, 0.0))
    assert shaded(deeper, STRIDE)[odd].all()
    assert not shaded(deeper, STRIDE, plane_tolerance=0.2)[odd].any()


@pytest.mark.parametrize(
    ("dark", "mean", "threshold", "is_shaded"),
    [
        (4.0, 1.0, {}, True),  # 2.5 times as bright
        (4.0, 1.0, {"edge_ratio": 4.0}, False),
        (6.0, 1.0, {}, False),
        (6.0, 1.0, {"edge_ratio": 1.5}, True),
        (1.0, 19.0, {}, True),
        (1.0, 19.0, {"min_edge": 0.2}, False),
    ],
)
def test_which_edges_of_light_are_shaded(
    dark: float, mean: float, threshold: dict[str, float], is_shaded: bool
) -> None:
    """The edges of light that is 10 on one side and `dark` on the other, reflected by π of it."""
    listed, _ = shaded_next(np.where(LEFT, dark, 10.0), mean=mean, **threshold)
    assert listed[1:-1:2, 23].all() == is_shaded
