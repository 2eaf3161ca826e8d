import pytest
import warp as wp


@pytest.fixture(scope="session", params=["cpu", "cuda:0"])
def device(request: pytest.FixtureRequest) -> str:
    """Each device in turn."""
    if request.param != "cpu" and not wp.is_cuda_available():
        pytest.skip("needs a CUDA device")
    return str(request.param)
