from dataclasses import replace

import pytest
from scenes import grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.pick import pick
from gpu.scene.camera import look_at
from gpu.scene.types import AlphaMode, Material

GLASS = Material("glass", transmission=1.0, roughness=0.0)
PART_GLASS = Material("part glass", transmission=0.9, roughness=0.0)
VEIL = Material("veil", base_color=(1.0, 1.0, 1.0, 0.1), alpha_mode=AlphaMode.BLEND)
HOLED = Material("holed", base_color=(1.0, 1.0, 1.0, 0.1), alpha_mode=AlphaMode.MASK)
# From (0, 0, 5) towards −Z, 90° high and wide.
CAMERA = look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), yfov_degrees=90.0, aspect=1.0)


@pytest.fixture(scope="module")
def sheets() -> DeviceScene:
    """Seen from the camera: clear glass on the left, a mask without a hole's edge on the right, a faint veil below and
    part glass above, before a wall.
    """
    parts = [
        quad((-2.0, -1.0, 2.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), 0),
        quad((-4.0, -4.0, 0.0), (8.0, 0.0, 0.0), (0.0, 8.0, 0.0), 1),
        quad((1.0, -1.0, 2.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), 2),
        quad((-0.5, -2.0, 2.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 3),
        quad((-0.5, 1.5, 2.0), (1.0, 0.0, 0.0), (0.0, 0.5, 0.0), 4),
    ]
    return resident_of(parts, [GLASS, grey(0.5), HOLED, VEIL, PART_GLASS])


@pytest.mark.parametrize(
    ("place", "material", "point"),
    [
        ((0.5, 0.5), 1, (0.0, 0.0, 0.0)),
        ((0.25, 0.5), 0, (-1.5, 0.0, 2.0)),  # glass, though it is seen through
        ((0.75, 0.5), 1, (2.5, 0.0, 0.0)),  # behind the mask, which lets all through
        ((0.5, 0.75), 3, (0.0, -1.5, 2.0)),  # a veil, too
        ((0.5, 0.2), 4, (0.0, 1.8, 2.0)),  # glass in part, too
        ((0.5, 0.1), 1, (0.0, 4.0, 0.0)),
    ],
)
def test_what_the_camera_sees_is_picked(
    sheets: DeviceScene, place: tuple[float, float], material: int, point: tuple[float, float, float]
) -> None:
    picked = pick(sheets, CAMERA, place)
    assert picked is not None
    assert sheets.scene.triangle_material[picked.triangle] == material
    assert picked.point == pytest.approx(point, abs=1e-5)
    assert picked.distance == pytest.approx(sum((a - b) ** 2 for a, b in zip(point, (0, 0, 5), strict=True)) ** 0.5)


def test_nothing_is_picked_where_nothing_is(sheets: DeviceScene) -> None:
    assert pick(sheets, CAMERA, (0.5, 0.05)) is None


def test_what_is_nearer_than_the_view_is_not_picked(sheets: DeviceScene) -> None:
    picked = pick(sheets, replace(CAMERA, near=4.0), (0.25, 0.5))
    assert picked is not None
    assert picked.point == pytest.approx((-2.5, 0.0, 0.0), abs=1e-5)
    assert picked.distance == pytest.approx((5.0**2 + 2.5**2) ** 0.5)
