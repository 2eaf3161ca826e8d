import warp as wp

from gpu.stages import Stages


def test_stages_run_in_order_and_are_timed_anew_each_frame() -> None:
    stages, ran = Stages(wp.get_device("cpu")), []
    for _ in range(3):
        stages.start_frame()
        stages.run("first", lambda: ran.append(1))
        stages.run("second", lambda: ran.append(2), repeats=False)
    assert ran == [1, 2] * 3
    times = stages.milliseconds()
    assert list(times) == ["first", "second"]
    assert all(0.0 <= ms < 1000.0 for ms in times.values())
    stages.start_frame()
    assert stages.milliseconds() == {}
