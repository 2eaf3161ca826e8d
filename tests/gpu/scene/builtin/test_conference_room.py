from builtin_scenes import heights, is_closed_and_shows_fronts, scene_of, world_corners


def test_is_closed_and_shows_its_fronts() -> None:
    assert is_closed_and_shows_fronts(scene_of("conference-room"), ("fig leaves",))


def test_its_panels_shine_from_the_ceiling() -> None:
    scene = scene_of("conference-room")
    low, _ = heights(scene, "ceiling panel")
    assert low > 0.9 * world_corners(scene)[..., 1].max()
