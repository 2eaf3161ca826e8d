import pytest

from gpu.settings import RenderSettings
from server.walk.resolution_scaler import LEAST_GPU_PIXELS, LEAST_SIDE, SCALES, TARGET_MS, ResolutionScaler

FULL = (1280, 720)
SETTINGS = RenderSettings()


def settle(
    scaler: ResolutionScaler,
    ms_of_pixels: float,
    fixed_ms: float = 0.0,
    frames: int = 200,
    full: tuple[int, int] = FULL,
) -> list[tuple[int, int]]:
    """The sizes of frames that take that much."""
    sizes = []
    for _ in range(frames):
        width, height = scaler.size(full, SETTINGS)
        sizes.append((width, height))
        scaler.observe(fixed_ms + ms_of_pixels * width * height)
    return sizes


def test_a_fast_device_renders_moving_frames_whole() -> None:
    assert settle(ResolutionScaler(), 10.0 / (1280 * 720))[-1] == FULL


def test_a_slow_device_renders_them_small_after_few_frames() -> None:
    sizes = settle(ResolutionScaler(), 700.0 / (1280 * 720))
    assert sizes[3] == sizes[-1] == (320, 180)


def test_a_size_whose_first_frames_are_slow_is_tried_again_once() -> None:
    def sizes_of(slow_times: int) -> list[tuple[int, int]]:
        """Of a fast device, on which the first two frames of a size take long, the first `slow_times` that it comes."""
        scaler, seen, sizes = ResolutionScaler(), {}, [(0, 0)]
        for _ in range(300):
            size = scaler.size(FULL, SETTINGS)
            if size != sizes[-1]:
                seen[size] = seen.get(size, 0) + 1
                since = len(sizes)
            sizes.append(size)
            prepares = len(sizes) - since <= 2 and seen[size] <= slow_times and size != (640, 360)
            scaler.observe(100.0 if prepares else 5.0)
        return sizes

    assert sizes_of(1)[60:] == [FULL] * 241
    # What is slow again is left for longer.
    assert FULL not in sizes_of(2)


@pytest.mark.parametrize("full_ms", [20, 33, 40, 50, 60, 80, 120, 200, 400])
@pytest.mark.parametrize("fixed_ms", [0.0, 8.0])
def test_the_size_settles_and_keeps_to_the_target(full_ms: float, fixed_ms: float) -> None:
    sizes = settle(ResolutionScaler(), full_ms / (1280 * 720), fixed_ms)
    last = sizes[-40:]
    assert len(set(last)) == 1
    width, height = last[0]
    assert fixed_ms + full_ms * width * height / (1280 * 720) <= 1.15 * TARGET_MS or width == FULL[0] * SCALES[-1]


def test_on_a_gpu_frames_are_not_made_so_small_that_they_come_no_sooner() -> None:
    scaler = ResolutionScaler(LEAST_GPU_PIXELS)
    sizes = settle(scaler, 10.0 / (480 * 270), 60.0, full=(480, 270))
    assert set(sizes) == {(480, 270), (320, 180)}
    assert sizes[10:] == [(320, 180)] * 190
    assert settle(scaler, 10.0 / (480 * 270), full=(480, 270), frames=1000)[-1] == (480, 270)
    assert scaler.size((480, 270), SETTINGS, 0.5) == (240, 135)
    assert ResolutionScaler(LEAST_GPU_PIXELS).size((96, 64), SETTINGS) == (96, 64)


@pytest.mark.parametrize(
    ("render_ms", "waited_ms", "full"), [(15.0, 20.0, True), (30.0, 0.0, False), (15.0, 60.0, False)]
)
def test_waiting_for_others_may_take_longer_than_a_frame(render_ms: float, waited_ms: float, full: bool) -> None:
    scaler = ResolutionScaler()
    for _ in range(20):
        scaler.size((640, 360), SETTINGS)
        scaler.observe(render_ms, waited_ms)
    assert (scaler.size((640, 360), SETTINGS) == (640, 360)) == full


def test_a_lock_is_obeyed_and_measures_nothing() -> None:
    scaler = ResolutionScaler()
    assert scaler.size(FULL, SETTINGS, 0.6) == (768, 432)
    scaler.observe(1e6)
    assert scaler.size(FULL, SETTINGS) == (640, 360)


def test_what_was_measured_while_a_lock_holds_is_of_no_size_to_be_chosen() -> None:
    scaler = ResolutionScaler()
    assert settle(scaler, 10.0 / (1280 * 720))[-1] == FULL
    for _ in range(9):
        scaler.size(FULL, SETTINGS, 1.0)
        scaler.observe(400.0)  # as when the scene has become slower
    for _ in range(9):
        scaler.size(FULL, SETTINGS, 0.25)
        scaler.observe(1.0)
    assert scaler.size(FULL, SETTINGS) == (640, 360)


def test_small_pictures_are_not_made_smaller_than_can_be_seen() -> None:
    assert pace_size((100, 80)) == (80, 64)
    assert pace_size((40, 30)) == (40, 30)
    assert min(pace_size((5000, 65))) == LEAST_SIDE


def pace_size(full: tuple[int, int]) -> tuple[int, int]:
    return ResolutionScaler().size(full, SETTINGS, 0.125)


def test_other_settings_begin_anew() -> None:
    scaler = ResolutionScaler()
    settle(scaler, 700.0 / (1280 * 720))
    scaler.restart()
    assert scaler.size(FULL, SETTINGS) == (640, 360)


def test_a_size_that_was_too_slow_is_tried_again_when_others_have_left() -> None:
    scaler = ResolutionScaler()
    assert settle(scaler, 200.0 / (1280 * 720))[-1] == (448, 252)
    assert settle(scaler, 10.0 / (1280 * 720), frames=1000)[-1] == FULL


def test_a_target_keeps_full_size_unless_the_viewer_wants_another() -> None:
    wanted = RenderSettings(target_ms=9.0)
    scaler = ResolutionScaler()
    for _ in range(9):
        assert scaler.size(FULL, wanted) == FULL
        scaler.observe(900.0)
    assert scaler.size(FULL, wanted, 0.6) == (768, 432)
