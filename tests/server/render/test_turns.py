import pytest

from gpu.settings import Method, RenderSettings
from server.render.turns import LIGHT_SAMPLES_A_TURN, PATHS_A_TURN, samples_a_turn


@pytest.mark.parametrize("method", Method)
@pytest.mark.parametrize("size", [(1, 1), (640, 360), (1280, 720), (16_384, 16_384)])
def test_a_turn_is_bounded(method: Method, size: tuple[int, int]) -> None:
    samples, pixels = samples_a_turn(RenderSettings(method=method), size), size[0] * size[1]
    most = PATHS_A_TURN if method is Method.PATH else LIGHT_SAMPLES_A_TURN
    assert samples == 1 or samples * pixels <= most < (samples + 1) * pixels
