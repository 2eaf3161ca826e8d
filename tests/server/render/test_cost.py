from dataclasses import replace

import pytest

from gpu.settings import RenderSettings
from server.render.cost import CPU_RAYS, CUDA_RAYS, MOST, TELLING_SECONDS, Speeds, TooLongError, frame_cost
from server.wire.worker import Render, SceneCamera, SceneRef

HALL = SceneRef("hall.glb", "/scenes/hall.glb", 1)
SETTINGS = RenderSettings(method="exact-vpl", vpls=1000, samples=1)
JOB = Render(3, HALL, SceneCamera(0), (1000, 500), SETTINGS, ".png")


def rays(job: Render = JOB, *, cuda: bool = False) -> float:
    return frame_cost(job.size, job.settings, cuda=cuda).rays


def test_a_frame_costs_what_the_counts_of_its_device_cost() -> None:
    cpu, gpu = (frame_cost((100, 10), RenderSettings(method="exact-vpl"), cuda=cuda) for cuda in (False, True))
    assert (cpu.pixels, gpu.pixels) == (1000, 1000)
    assert gpu.rays > 5 * cpu.rays


@pytest.mark.parametrize(("cuda", "usual"), [(False, CPU_RAYS), (True, CUDA_RAYS)])
def test_what_nothing_is_known_of_is_expected_to_be_fast(cuda: bool, usual: float) -> None:
    assert Speeds().seconds(JOB, cuda=cuda) == rays(cuda=cuda) / usual


def test_frames_that_were_timed_tell_how_long_others_take() -> None:
    speeds = Speeds()
    speeds.learn(JOB, 100.0, cuda=False)  # kernels were compiled
    assert speeds.seconds(JOB, cuda=False) == rays() / CPU_RAYS
    for seconds in (20.0, 10.0, 30.0, TELLING_SECONDS / 2):
        speeds.learn(JOB, seconds, cuda=False)
    assert speeds.seconds(JOB, cuda=False) == pytest.approx(10.0)
    larger = replace(JOB, size=(2000, 1000))
    assert speeds.seconds(larger, cuda=False) == pytest.approx(40.0, rel=0.01)
    for other in (replace(JOB, scene=replace(HALL, stamp=2)), replace(JOB, settings=RenderSettings(method="path"))):
        assert speeds.seconds(other, cuda=False) == rays(other) / CPU_RAYS


def test_what_takes_too_long_is_refused_with_what_would_do() -> None:
    speeds = Speeds()
    for _ in range(2):
        speeds.learn(JOB, 10.0, cuda=False)
    speeds.check(JOB, 6, 60.0, cuda=False)
    with pytest.raises(TooLongError, match=r"1000×500 .* 24 frames .* 4 min, more than the 60 s .*500×250 .* 6 frames"):
        speeds.check(JOB, 24, 60.0, cuda=False)
    with pytest.raises(TooLongError, match=r"10 s, more than the 2.5 s .* 500×250 pixels, or fewer"):
        speeds.check(JOB, 1, 2.5, cuda=False)
    with pytest.raises(TooLongError, match="3 h"):
        speeds.check(JOB, 1080, 2.5, cuda=False)


def test_a_bounded_number_of_kinds_is_remembered() -> None:
    speeds = Speeds()
    for stamp in [*range(MOST), 0, MOST]:
        speeds.learn(replace(JOB, scene=replace(HALL, stamp=stamp)), 10.0, cuda=False)
    assert len(speeds._rays) == MOST
    assert {kind.scene.stamp for kind in speeds._rays} == {0, *range(2, MOST + 1)}
