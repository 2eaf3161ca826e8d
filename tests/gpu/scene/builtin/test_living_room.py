from builtin_scenes import heights, is_closed_and_shows_fronts, scene_of


def test_is_closed_and_shows_its_fronts() -> None:
    assert is_closed_and_shows_fronts(scene_of("living-room"), ("fig leaves", "twig leaves", "linen"))


def test_its_window_shows_a_sky_above_a_lawn_and_curtains_that_reach_the_floor() -> None:
    scene = scene_of("living-room")
    assert heights(scene, "lawn")[1] < heights(scene, "sky")[1]
    low, high = heights(scene, "linen")
    assert low < 0.05
    assert high > 2.4
