"""JPEGs made on the GPU, from the picture where it lies: nvImageCodec, where that is installed.

    pip install nvidia-nvimgcodec-cu13 nvidia-nvjpeg

No copy of the pixels to the host, and a fifth of a millisecond for 1080p instead of five to nine on a CPU's core. A
thread waits for it, on a stream of its own, while the host goes on with other frames.
"""

import logging
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import warp as wp

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import CAPTURING
from server.worker.encode import FINE_QUALITY

log = logging.getLogger("lumenwalk.encode")


class DeviceEncoder:
    """Encodes pictures of one CUDA device."""

    def __init__(self, device: wp.Device) -> None:
        """ImportError without nvImageCodec, RuntimeError when it cannot encode here."""
        from nvidia import nvimgcodec

        self._codec: Any = nvimgcodec
        self._stream = wp.Stream(device, priority=-1)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="device-encode")
        self._encoder: Any = self._thread.submit(nvimgcodec.Encoder, device_id=device.ordinal).result()
        black = wp.zeros((64 * 64, 3), dtype=wp.uint8, device=device)
        wp.synchronize_device(device)
        self.encode(black, (64, 64), FINE_QUALITY)

    def encode(self, pixels: wp.array, size: tuple[int, int], quality: int) -> bytes:
        """A JPEG of `pixels` (pixel, 3) uint8 sRGB on the device, of `size` (width, height); as
        server.worker.encode. They are ready, and stay until this returns; others have the host meanwhile.
        """
        image = self._thread.submit(self._encode, pixels, size, quality)
        DEVICE_SHARING.leave_until(image.done)
        return image.result()

    def _encode(self, pixels: wp.array, size: tuple[int, int], quality: int) -> bytes:
        codec = self._codec
        sampling = codec.ChromaSubsampling.CSS_444 if quality >= FINE_QUALITY else codec.ChromaSubsampling.CSS_420
        params = codec.EncodeParams(
            quality_type=codec.QualityType.QUALITY, quality_value=quality, chroma_subsampling=sampling
        )
        stream = self._stream.cuda_stream
        with CAPTURING:
            image = codec.as_image(pixels.reshape((size[1], size[0], 3)), cuda_stream=stream)
            encoded = self._encoder.encode(image, "jpeg", params=params, cuda_stream=stream)
        if encoded is None:
            raise RuntimeError(f"nvImageCodec cannot encode a picture of {size[0]}×{size[1]} pixels")
        return bytes(memoryview(encoded))


def device_encoder(device: wp.Device) -> DeviceEncoder | None:
    """The encoder of a device; None on a CPU, and where nvImageCodec is missing or does not work."""
    if not device.is_cuda:
        return None
    try:
        return DeviceEncoder(device)
    except ImportError:
        log.info("frames are encoded on the CPU; nvidia-nvimgcodec-cu13 and nvidia-nvjpeg would do it on the GPU")
    except Exception as error:
        log.warning("frames are encoded on the CPU: %s", error)
    return None
