from scenes import box, grey, resident_of

from gpu.core.stages import Stages
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.view_state import ViewState
from gpu.sample_counts import sample_counts_of
from gpu.scene.camera import look_at
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets


class Grey(RenderMethod[ViewState]):
    """The least that a method is."""

    def __init__(self, setup: RenderSetup) -> None:
        self._setup = setup

    def new_view(self) -> ViewState:
        return ViewState(self._setup.device_scene, self._setup.size)

    def render(self, view: ViewState, stages: Stages, sample: int) -> None:
        view.radiance.fill_(0.5)

    def statistics(self, view: ViewState) -> FrameStatistics:
        return {}, {}


def test_a_method_shows_the_one_frame_that_is_asked_for_and_expects_nothing() -> None:
    device_scene, settings = resident_of(box(), [grey(0.5)]), RenderSettings()
    counts = sample_counts_of(settings, device_scene.device)
    setup = RenderSetup(device_scene, LightSets(device_scene), (4, 3), settings, counts, lambda *_: None)
    assert setup.pixels == 12
    assert setup.device == device_scene.device
    method, camera, shown = Grey(setup), look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0)), []
    view = method.new_view()
    once = lambda camera, accumulation: shown.append((camera, accumulation)) or "frame"  # noqa: E731
    assert method.show(once, view, camera, None, walks=False) == "frame"  # type: ignore[arg-type]
    assert shown == [(camera, None)]
    assert method.estimates(view) == {}
    assert method.cluster_bytes(counts) == (0, 0)
