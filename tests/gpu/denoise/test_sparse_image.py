import numpy as np
from walls import CPU, HEIGHT, LEFT, WIDTH, wall

from gpu.denoise.sparse_image import sparse_image
from gpu.gbuffer.shading_points import ShadingPoints


def test_an_image_tells_which_of_its_pixels_have_points() -> None:
    sps = ShadingPoints((WIDTH, HEIGHT), 1, CPU)
    sps.find(wall(seen=LEFT))
    sparse = sparse_image((WIDTH, HEIGHT), sps)
    assert (sparse.image.width, sparse.image.height, sparse.stride) == (WIDTH, HEIGHT, 1)
    assert np.array_equal(sparse.listed.numpy().reshape(HEIGHT, WIDTH), LEFT.astype(int))


def test_with_a_stride_few_pixels_are_listed() -> None:
    sps = ShadingPoints((WIDTH, HEIGHT), 2, CPU)
    sps.find(wall())
    sparse = sparse_image((WIDTH, HEIGHT), sps)
    assert sparse.stride == 2
    assert sparse.listed.numpy().sum() == sps.count.numpy()[0] < WIDTH * HEIGHT
