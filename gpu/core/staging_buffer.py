"""Pinned staging buffers: small arrays that are copied between host and device without either waiting."""

import numpy as np
import warp as wp


class StagingBuffer:
    """`array` of a device and `host`, a NumPy view of as many values in page-locked memory of the host.

    Copies run in the order of the device's stream, and may be captured. The host waits for the device before it reads
    what was downloaded, or writes what is to be uploaded next.
    """

    def __init__(self, array: wp.array) -> None:
        self.array = array
        self._locked = wp.zeros(array.shape, dtype=array.dtype, device="cpu", pinned=array.device.is_cuda)
        self.host: np.ndarray = self._locked.numpy()

    def upload(self) -> None:
        """Copy `host` into `array`."""
        wp.copy(self.array, self._locked)

    def download(self) -> None:
        """Copy `array` into `host`."""
        wp.copy(self._locked, self.array)
