"""A scene for tests of VPLs that are placed by hand."""

import pytest
from scenes import box, grey, resident_of

from gpu.device_scene.upload import DeviceScene


@pytest.fixture(scope="module")
def device_scene() -> DeviceScene:
    return resident_of(box(), [grey(0.5, 1.0)])
