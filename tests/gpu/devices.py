"""The devices that tests run on: the CPU, and a CUDA device where there is one."""

import pytest
import warp as wp

NEEDS_CUDA = pytest.mark.skipif(not wp.is_cuda_available(), reason="needs a CUDA device")
DEVICES = ["cpu", pytest.param("cuda:0", marks=NEEDS_CUDA)]
