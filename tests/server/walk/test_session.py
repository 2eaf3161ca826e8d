from dataclasses import dataclass, field
from typing import Any

import pytest

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, LightEdit, SceneEdits
from gpu.settings import Method, RenderSettings
from server.render.schedule import Urgency
from server.render.turns import samples_a_turn
from server.walk.frame_request import FrameRequest
from server.walk.session import (
    LONG_REST_SECONDS,
    MAX_LOSSES,
    MAX_SHRINKS,
    REST_SECONDS,
    SAMPLES_A_FRAME,
    Qualities,
    Session,
)
from server.wire.browser import WINDOW, Pose, Stream
from server.wire.frame_header import LOSSLESS, Codec
from server.wire.worker import CameraMatrix, Done, Render, SceneRef

HALL, YARD = SceneRef("hall", "hall"), SceneRef("yard", "yard")
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
FULL = (640, 360)
OFF = SceneEdits(lights={"lamp": LightEdit(on=False)})


def pose(number: int, x: float | None = None) -> Pose:
    place = float(number) if x is None else x
    return Pose(type="pose", id=number, matrix=(*IDENTITY[:12], place, *IDENTITY[13:]), yfov=1.0)


@dataclass
class Clock:
    """Time that stands still unless a test lets it pass."""

    time: float = 100.0

    def __call__(self) -> float:
        return self.time


@dataclass
class Desk:
    """A session whose scene is open, and a worker that averages 4 frames."""

    clock: Clock = field(default_factory=Clock)
    options: dict[str, Any] = field(default_factory=dict)
    settings: RenderSettings = field(default_factory=RenderSettings)
    render_ms: float = 10.0

    def __post_init__(self) -> None:
        self.session = Session(7, FULL, self.settings, now=self.clock, **self.options)
        self.session.show(HALL)

    def take(self) -> tuple[FrameRequest, Render]:
        taken = self.session.take()
        assert taken is not None
        return taken

    def serve(self, samples: int | None = None, size: int = 1000, way: float = 0.0) -> tuple[FrameRequest, Render]:
        """One frame, rendered, shown and acknowledged; samples: that the worker has averaged, when not all; size: in
        bytes, of which each is so many seconds on its way.
        """
        request, job = self.take()
        have = request.samples if samples is None else samples
        done = Done(1, job.size, self.render_ms, 1.0, have or 1, 4, {}, {}, {})
        self.session.delivered(request, done, 0.0)
        if request.frame is not None:
            self.session.sent(request.header(done), size)
            self.clock.time += way * size
            self.session.acknowledge(request.frame)
        return request, job

    def rest(self, seconds: float = REST_SECONDS) -> None:
        self.clock.time += seconds


@pytest.fixture
def desk() -> Desk:
    return Desk()


def test_nothing_is_due_before_a_scene_and_a_pose() -> None:
    session = Session(1, FULL, RenderSettings())
    session.pose(pose(1))
    assert session.due is None
    session.show(HALL)
    assert session.due is None, "the pose came before the scene and was not meant for it"
    session.pose(pose(2))
    assert session.due is Urgency.MOVING


def test_the_newest_pose_is_rendered_once(desk: Desk) -> None:
    for number in (1, 2, 3):
        desk.session.pose(pose(number))
    request, job = desk.take()
    assert (request.frame, request.pose, request.samples) == (1, 3, None)
    assert job == Render(
        7, HALL, CameraMatrix(pose(3).matrix, 1.0), FULL, RenderSettings(), "jpeg", walks=True, quality=80
    )
    assert desk.session.due is None
    assert desk.session.take() is None


def test_a_section_begins_where_the_pose_says(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.session.pose(pose(1).model_copy(update={"near": 2.5}))
    assert desk.session.due is Urgency.MOVING
    assert desk.take()[1].view == CameraMatrix(pose(1).matrix, 1.0, 2.5)


@pytest.mark.parametrize(("scale", "size"), [(0.5, (320, 180)), (1.0, FULL)])
def test_a_view_that_rests_is_rendered_whole_and_refined(desk: Desk, scale: float, size: tuple[int, int]) -> None:
    desk.session.change(1, stream=Stream(motion_scale=scale))
    desk.session.pose(pose(1))
    _, moving = desk.serve()
    assert (moving.size, moving.sample, moving.quality, moving.walks) == (size, None, 80, True)
    assert desk.session.due is None
    assert desk.session.rest_seconds == pytest.approx(REST_SECONDS)
    desk.rest()
    assert desk.session.due is Urgency.STILL
    frames = []
    for expected in range(4):
        request, job = desk.serve()
        assert (job.sample, request.samples, job.size, job.quality) == (expected, expected + 1, FULL, 92)
        assert job.walks == (expected == 0 and size == FULL)  # a walk leaves its last frame to the mean
        frames.append((request.frame, job.output))
        assert desk.session.due is (Urgency.REFINING if expected < 3 else None)
    assert frames == [(2, "jpeg"), (3, "jpeg"), (None, "none"), (4, "jpeg")]
    desk.rest(60.0)
    assert desk.session.due is None


@pytest.mark.parametrize("target", [{"target_ms": 9.0}, {"target_error": 1e-3}])
def test_moving_frames_with_a_target_are_whole_unless_locked(desk: Desk, target: dict[str, float]) -> None:
    desk.render_ms = 900.0
    sizes = []
    for number, settings in enumerate((RenderSettings(**target), RenderSettings()), 1):
        desk.session.change(number, settings=settings)
        for step in range(6):
            desk.session.pose(pose(10 * number + step))
            sizes.append(desk.serve()[1].size)
        desk.rest()
        assert not desk.serve()[1].walks
    assert sizes[:6] == [FULL] * 6
    assert sizes[-1] < FULL
    desk.session.change(3, settings=RenderSettings(**target), stream=Stream(motion_scale=0.5))
    desk.session.pose(pose(30))
    assert desk.serve()[1].size == (320, 180)


def test_motion_ends_refinement_and_refinement_begins_anew(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    desk.serve()
    desk.serve()
    desk.session.pose(pose(2))
    assert desk.session.due is Urgency.MOVING
    assert desk.serve()[1].sample is None
    desk.rest()
    assert desk.serve()[1].sample == 0


def test_a_pose_that_is_where_the_last_one_was_moves_nothing(desk: Desk) -> None:
    desk.session.pose(pose(1, x=0.5))
    desk.serve()
    desk.rest()
    desk.serve()
    desk.session.pose(pose(2, x=0.5))
    assert desk.session.due is Urgency.REFINING
    assert desk.serve()[0].pose == 2


def test_a_still_frame_that_takes_long_waits_for_a_longer_rest() -> None:
    desk = Desk(render_ms=900.0)
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    desk.serve()
    desk.session.pose(pose(2))
    desk.serve()
    desk.rest()
    assert desk.session.due is None
    desk.rest(LONG_REST_SECONDS - REST_SECONDS)
    assert desk.session.due is Urgency.STILL


def test_a_worker_that_lost_the_mean_is_followed(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    desk.serve()
    desk.serve(samples=1)
    assert desk.serve()[1].sample == 1


def test_a_mean_that_was_lost_becomes_final_with_one_frame_on_its_way_all_the_time(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    has, rendering = 0, None
    for turn in range(20):
        if turn == 3:
            has = 0  # the worker was started anew between two frames
        taken = desk.session.take()
        if rendering is not None:  # the worker says what it has when the next frame is with it already
            request, samples = rendering
            desk.session.delivered(request, Done(1, FULL, 1.0, 1.0, samples, 8, {}, {}, {}), 0.0)
            if request.frame is not None:
                desk.session.window.sent(request.frame)
                desk.session.acknowledge(request.frame)
        if taken is None:
            break
        has = has + 1 if taken[1].sample == has else 1
        rendering = taken[0], has
    assert has == 8


def test_two_frames_lost_with_one_worker_are_one_loss(desk: Desk) -> None:
    for number in range(1, MAX_LOSSES):
        desk.session.pose(pose(number))
        requests = [desk.take()[0]]
        desk.session.pose(pose(number, x=-1.0))
        requests.append(desk.take()[0])
        assert [desk.session.lost(request) for request in requests] == [True, True]
    assert not desk.session.lost(desk.take()[0])


def test_the_last_word_of_an_earlier_view_does_not_count(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    desk.serve()
    request, job = desk.take()
    desk.session.pose(pose(2))
    desk.serve()
    desk.rest()
    desk.serve()
    desk.serve()
    desk.session.delivered(request, Done(1, job.size, 1.0, 1.0, 1, 4, {}, {}, {}), 0.0)
    assert desk.take()[1].sample == 2


@pytest.mark.parametrize("takes_png", [True, False])
def test_the_final_frame_is_lossless_for_viewers_who_want_and_can_take_it(takes_png: bool) -> None:
    desk = Desk(options={"stream": Stream(lossless=True), "codecs": ["png"] if takes_png else []})
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    shown = [desk.serve() for _ in range(4)]
    assert {(request.codec, job.output) for request, job in shown[:2]} == {(Codec.JPEG, "jpeg")}
    request, job = shown[-1]
    if takes_png:
        assert (request.codec, request.quality, job.output) == (Codec.PNG, LOSSLESS, ".png")
    else:
        assert (request.codec, job.output) == (Codec.JPEG, "jpeg")


@pytest.mark.parametrize("takes_video", [True, False])
def test_moving_frames_are_video_for_viewers_who_want_and_can_take_it(takes_video: bool) -> None:
    desk = Desk(options={"stream": Stream(video=True), "codecs": ["h264"] if takes_video else []})
    moving = []
    for number in (1, 2, 3):
        desk.session.pose(pose(number))
        moving.append(desk.serve())
    desk.rest()
    still = desk.serve()
    assert (still[0].codec, still[1].output) == (Codec.JPEG, "jpeg")
    expected = (Codec.H264, "h264", [1, 2, 3]) if takes_video else (Codec.JPEG, "jpeg", [0, 0, 0])
    assert [(one.codec, job.output, job.video) for one, job in moving] == [(*expected[:2], it) for it in expected[2]]


def test_a_frame_of_video_says_whether_it_needs_another() -> None:
    desk = Desk(options={"stream": Stream(video=True), "codecs": ["h264"]})
    desk.session.pose(pose(1))
    request, job = desk.take()
    for is_key, codec in ((True, Codec.H264_KEY), (False, Codec.H264)):
        done = Done(1, job.size, 1.0, 1.0, 1, 4, {}, {}, {}, is_key=is_key)
        assert request.header(done).codec is codec


def test_a_frame_that_was_broken_is_followed_by_one_that_needs_no_other() -> None:
    desk = Desk(options={"stream": Stream(video=True), "codecs": ["h264"]})
    desk.session.pose(pose(1))
    request, job = desk.serve()
    assert request.frame is not None
    desk.session.acknowledge(request.frame, broken=True)
    desk.session.pose(pose(2))
    assert desk.serve()[1].video == job.video + 2  # which the encoder sees does not follow on


@pytest.mark.parametrize(("wish", "output"), [(None, "h264"), (False, "jpeg")])
def test_a_slow_line_has_video_unless_the_viewer_wants_none(wish: bool | None, output: str) -> None:
    desk = Desk(options={"stream": Stream(video=wish), "codecs": ["h264"]})
    for number in range(1, 40):
        desk.session.pose(pose(number))
        job = desk.serve(size=4000 if desk.session._video_choice.is_video else 40_000, way=1.6e-6)[1]
    assert job.output == output


def test_qualities_are_the_services() -> None:
    desk = Desk(options={"qualities": Qualities(moving=50, still=99)})
    desk.session.pose(pose(1))
    assert desk.serve()[1].quality == 50
    desk.rest()
    assert desk.serve()[1].quality == 99


def test_one_frame_may_be_all_that_is_wanted() -> None:
    desk = Desk(settings=RenderSettings(frames=1))
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    desk.take()
    assert desk.session.due is None


def test_a_walk_by_paths_takes_few_at_once() -> None:
    desk = Desk(settings=RenderSettings(method=Method.PATH))
    desk.session.pose(pose(1))
    assert desk.take()[1].settings.samples == SAMPLES_A_FRAME
    desk.session.change(1, settings=RenderSettings(method=Method.PATH, samples=9))
    assert desk.take()[1].settings.samples == 9


@pytest.mark.parametrize("method", Method)
def test_a_frame_takes_no_more_samples_than_a_turn(method: Method) -> None:
    settings = RenderSettings(method=method, samples=65_536)
    desk = Desk(settings=settings)
    desk.session.pose(pose(1))
    for _ in range(2):
        render = desk.serve()[1]
        assert render.settings.samples == samples_a_turn(settings, render.size)
        desk.rest()


def test_slow_frames_are_followed_by_smaller_ones_but_for_those_of_earlier_settings(desk: Desk) -> None:
    desk.session.pose(pose(1))
    late, _ = desk.take()
    desk.session.change(1, settings=RenderSettings(seed=2))
    newest, job = desk.take()
    for request, is_smaller in ((late, False), (newest, True)):
        desk.session.delivered(request, Done(1, job.size, 300.0, 1.0, 1, 4, {}, {}, {}), 0.0)
        assert (desk.session._scaler.size(FULL, RenderSettings()) < FULL) == is_smaller


def test_the_window_closes_and_an_acknowledgement_opens_it(desk: Desk) -> None:
    for number in range(1, WINDOW + 1):
        desk.session.pose(pose(number))
        desk.take()
    desk.session.pose(pose(9))
    assert desk.session.due is None
    desk.session.window.sent(1)
    desk.session.acknowledge(1)
    assert desk.take()[0].pose == 9


def test_a_full_window_holds_refinement_back(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.take()
    desk.rest()
    for _ in range(WINDOW - 1):
        desk.take()
    assert desk.session.due is None


def test_a_frame_that_was_not_sent_cannot_be_acknowledged(desk: Desk) -> None:
    desk.session.pose(pose(1))
    request, _ = desk.take()
    assert request.frame == 1
    with pytest.raises(UserError, match="frame 1 has not been sent"):
        desk.session.acknowledge(1)
    desk.session.window.sent(1)
    desk.session.acknowledge(1)


def test_settings_render_the_same_pose_again(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.session.change(5, (32, 18), RenderSettings(method=Method.EXACT_VPL))
    request, job = desk.serve()
    assert (request.pose, request.settings, job.size, job.settings.method) == (1, 5, (32, 18), Method.EXACT_VPL)
    desk.session.change(6)
    assert desk.serve()[1].size == (32, 18)


def test_another_scene_waits_for_a_pose_of_its_own(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.session.show(None)
    desk.session.pose(pose(2))
    desk.session.show(YARD)
    assert desk.session.due is None
    desk.session.pose(pose(3))
    assert desk.take()[1].scene == YARD


def test_settings_that_fail_are_not_tried_again_until_they_change(desk: Desk) -> None:
    desk.session.pose(pose(1))
    first = desk.take()[0]
    desk.session.pose(pose(2))
    second = desk.take()[0]
    assert desk.session.failed(first)
    assert not desk.session.failed(second), "it fails for the same reason"
    desk.session.pose(pose(5))
    assert desk.session.due is None
    desk.session.change(1, settings=RenderSettings(seed=2))
    for _ in range(WINDOW):  # the failed frame has left the window
        desk.take()
        desk.session.pose(pose(3))
        desk.session.pose(pose(4))


def test_a_late_failure_does_not_block_newer_settings(desk: Desk) -> None:
    desk.session.pose(pose(1))
    request, _ = desk.take()
    desk.session.change(1, settings=RenderSettings(seed=2))
    desk.session.failed(request)
    assert desk.session.due is Urgency.MOVING


def test_too_little_memory_makes_pictures_smaller_and_then_is_an_error(desk: Desk) -> None:
    desk.session.change(1, stream=Stream(motion_scale=1.0))
    desk.session.pose(pose(1))
    sizes = []
    for _ in range(MAX_SHRINKS):
        request, job = desk.take()
        sizes.append(job.size)
        assert desk.session.shrink(request)
    request, job = desk.take()
    sizes.append(job.size)
    assert sizes == [FULL, (320, 180), (160, 90)]
    assert not desk.session.shrink(request)
    assert desk.session.due is None
    desk.session.change(2, size=(64, 36))
    assert desk.take()[1].size == (64, 36)


def test_too_little_memory_for_earlier_settings_is_no_matter(desk: Desk) -> None:
    desk.session.pose(pose(1))
    request, _ = desk.take()
    desk.session.change(1, settings=RenderSettings(seed=1), stream=Stream(motion_scale=1.0))
    assert desk.session.shrink(request)
    assert desk.take()[1].size == FULL


def test_a_lost_frame_is_tried_again_but_not_for_ever(desk: Desk) -> None:
    desk.session.pose(pose(1))
    for _ in range(MAX_LOSSES - 1):
        assert desk.session.lost(desk.take()[0])
        assert desk.session.due is Urgency.MOVING
    assert not desk.session.lost(desk.take()[0])
    assert desk.session.due is None


def test_a_delivered_frame_forgives_losses(desk: Desk) -> None:
    desk.session.pose(pose(1))
    for number in range(MAX_LOSSES):
        assert desk.session.lost(desk.take()[0])
        desk.serve()
        desk.session.pose(pose(number + 2))


def test_the_queue_time_counts_from_the_newest_change(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.rest(1.0)
    desk.session.pose(pose(2))
    desk.rest(0.25)
    assert desk.take()[0].queue_ms == pytest.approx(250.0)


def test_an_edit_is_in_the_next_frame_and_restarts_the_mean(desk: Desk) -> None:
    desk.session.pose(pose(1))
    desk.serve()
    desk.rest()
    while desk.session.due is not None:
        desk.serve()
    desk.session.edit(OFF)
    assert desk.session.due is Urgency.MOVING
    assert desk.serve()[1].edits == OFF
    desk.rest()
    request, job = desk.serve()
    assert (request.samples, job.sample, job.edits) == (1, 0, OFF)
    desk.session.show(YARD)
    desk.session.pose(pose(2))
    assert desk.take()[1].edits == NO_EDITS


def test_a_view_that_failed_is_tried_again_after_an_edit(desk: Desk) -> None:
    desk.session.pose(pose(1))
    assert desk.session.failed(desk.take()[0])
    assert desk.session.due is None
    desk.session.edit(OFF)
    assert desk.session.due is Urgency.MOVING
