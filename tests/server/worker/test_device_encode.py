"""JPEGs made on a GPU; without one, that the CPU does it instead."""

import numpy as np
import pytest
import simplejpeg
import warp as wp
from devices import NEEDS_CUDA

from server.worker.device_encode import DeviceEncoder, device_encoder


def test_a_cpu_has_none() -> None:
    assert device_encoder(wp.get_device("cpu")) is None


@NEEDS_CUDA
@pytest.mark.parametrize(("quality", "sampling"), [(80, "420"), (95, "444")])
def test_a_gpu_encodes_where_the_picture_lies(quality: int, sampling: str) -> None:
    pytest.importorskip("nvidia.nvimgcodec")
    device = wp.get_device("cuda:0")
    picture = np.zeros((36, 64, 3), np.uint8)
    picture[..., 0] = np.linspace(0, 255, 64)
    picture[..., 1] = np.linspace(0, 255, 36)[:, None]
    pixels = wp.array(picture.reshape(-1, 3), dtype=wp.uint8, device=device)
    image = DeviceEncoder(device).encode(pixels, (64, 36), quality)
    assert simplejpeg.decode_jpeg_header(image)[:2] == (36, 64)
    assert simplejpeg.decode_jpeg_header(image)[3] == sampling
    assert np.abs(simplejpeg.decode_jpeg(image).astype(int) - picture).mean() < 4.0
