from gpu.core.image_size import image_size


def test_a_size_is_width_then_height() -> None:
    image = image_size((7, 5))
    assert (image.width, image.height) == (7, 5)
