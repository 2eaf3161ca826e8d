import pytest
import warp as wp

from server.worker.list_devices import names


def test_every_gpu_is_named_or_else_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    assert names() == ([device.alias for device in wp.get_cuda_devices()] or ["cpu"])
    monkeypatch.setattr(wp, "get_cuda_devices", list)
    assert names() == ["cpu"]
