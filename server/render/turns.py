"""How many samples one turn takes, so that others get theirs soon; more are taken in more turns, and averaged."""

from gpu.settings import RenderSettings

# Pixels times samples of a turn: 50 ms of an H100, and some seconds of a CPU's core; with fewer a turn costs more than
# it does. Light samples, a ray each, are cheaper than paths.
PATHS_A_TURN = 1 << 22
LIGHT_SAMPLES_A_TURN = 1 << 25


def samples_a_turn(settings: RenderSettings, size: tuple[int, int]) -> int:
    """The most samples a pixel that a frame of `size` takes in one turn: at least one."""
    most = PATHS_A_TURN if settings.method.refines_by_samples else LIGHT_SAMPLES_A_TURN
    return max(1, most // (size[0] * size[1]))
