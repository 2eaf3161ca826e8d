"""JPEGs made on a GPU; without one, that the CPU does it instead."""

import sys
from collections.abc import Callable
from threading import current_thread
from types import SimpleNamespace

import numpy as np
import pytest
import simplejpeg
import warp as wp
from devices import NEEDS_CUDA

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import CAPTURING
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
    wp.synchronize_device(device)
    image = DeviceEncoder(device).encode(pixels, (64, 36), quality)
    assert simplejpeg.decode_jpeg_header(image)[:2] == (36, 64)
    assert simplejpeg.decode_jpeg_header(image)[3] == sampling
    assert np.abs(simplejpeg.decode_jpeg(image).astype(int) - picture).mean() < 4.0


def test_a_thread_waits_for_the_encoder_while_others_have_the_host(monkeypatch: pytest.MonkeyPatch) -> None:
    threads, left = list[str](), list[int]()

    class Encoder:
        def __init__(self, device_id: int) -> None:
            threads.append(current_thread().name)

        def encode(self, image: wp.array, *_: object, **__: object) -> bytes | None:
            assert CAPTURING.locked()
            threads.append(current_thread().name)
            return None if image.shape == (1, 2, 3) else bytes(image.shape)

    class Codec(SimpleNamespace):
        ChromaSubsampling = SimpleNamespace(CSS_444=0, CSS_420=0)
        QualityType = SimpleNamespace(QUALITY=0)

    class Turns:
        def due(self, *, idle: bool = False) -> bool:
            return False

        def give(self) -> None:
            raise AssertionError("nobody asked")

        def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
            left.append(1)

    codec = Codec(Encoder=Encoder, EncodeParams=lambda **_: None, as_image=lambda array, cuda_stream: array)
    monkeypatch.setitem(sys.modules, "nvidia", SimpleNamespace(nvimgcodec=codec))
    monkeypatch.setattr(wp, "Stream", lambda device, priority: SimpleNamespace(cuda_stream=0))
    encoder = DeviceEncoder(wp.get_device("cpu"))
    DEVICE_SHARING.begin(Turns())
    try:
        assert encoder.encode(wp.zeros((8, 3), dtype=wp.uint8, device="cpu"), (4, 2), 80) == bytes((2, 4, 3))
        with pytest.raises(RuntimeError, match="2×1 pixels"):
            encoder.encode(wp.zeros((2, 3), dtype=wp.uint8, device="cpu"), (2, 1), 80)
    finally:
        DEVICE_SHARING.begin(None)
    assert left == [1, 1]
    assert {name.startswith("device-encode") for name in threads} == {True}
