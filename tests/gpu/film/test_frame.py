import numpy as np
import warp as wp
from scenes import column

from gpu.core.lane import Lane
from gpu.core.staging_buffer import StagingBuffer
from gpu.film.frame import Frame, FrameStats


def test_images_have_rows_from_the_top_and_are_copies() -> None:
    radiance, pixels = column(np.arange(18).reshape(6, 3), wp.vec3), column(np.arange(18).reshape(6, 3), wp.uint8)
    frame = Frame((3, 2), radiance, StagingBuffer(pixels), FrameStats(), Lane(wp.get_device("cpu")))
    for image, dtype in ((frame.radiance(), np.float32), (frame.pixels(), np.uint8)):
        assert image.dtype == dtype
        assert np.array_equal(image, np.arange(18).reshape(2, 3, 3))
    kept = frame.radiance(), frame.pixels()
    radiance.zero_()
    pixels.zero_()
    assert kept[0].sum() == kept[1].sum() == 153
    assert not frame.radiance().any()
