import pytest

from gpu.errors import UserError
from gpu.settings import Method, RenderSettings
from server.messages import Placed, Render, SceneRef
from server.protocol import WINDOW, Pose
from server.session import MAX_LOSSES, Order, Session

HALL, YARD = SceneRef("hall", "hall"), SceneRef("yard", "yard")
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def pose(number: int) -> Pose:
    return Pose(type="pose", id=number, matrix=(*IDENTITY[:12], float(number), *IDENTITY[13:]), yfov=1.0)


@pytest.fixture
def session() -> Session:
    """A session whose scene is open and whose clock stands still."""
    session = Session(7, (64, 36), RenderSettings(), now=lambda: 0.0)
    session.show(HALL)
    return session


def take(session: Session) -> tuple[Order, Render]:
    taken = session.take()
    assert taken is not None
    return taken


def test_nothing_is_due_before_a_scene_and_a_pose() -> None:
    session = Session(1, (64, 36), RenderSettings())
    session.pose(pose(1))
    assert not session.due
    session.show(HALL)
    assert not session.due, "the pose came before the scene and was not meant for it"
    session.pose(pose(2))
    assert session.due


def test_the_newest_pose_is_rendered_once(session: Session) -> None:
    for number in (1, 2, 3):
        session.pose(pose(number))
    order, job = take(session)
    assert (order.frame, order.pose) == (1, 3)
    assert job == Render(7, HALL, Placed(pose(3).matrix, 1.0), (64, 36), RenderSettings(), "jpeg")
    assert not session.due
    assert session.take() is None


def test_the_window_closes_and_an_acknowledgement_opens_it(session: Session) -> None:
    for number in range(1, WINDOW + 1):
        session.pose(pose(number))
        take(session)
    session.pose(pose(9))
    assert not session.due
    session.acknowledge(1)
    assert take(session)[0].pose == 9


def test_an_acknowledgement_covers_older_frames(session: Session) -> None:
    for number in range(1, WINDOW + 1):
        session.pose(pose(number))
        take(session)
    session.acknowledge(WINDOW)
    for number in range(1, WINDOW + 1):
        session.pose(pose(number))
        take(session)


def test_a_frame_that_was_not_sent_cannot_be_acknowledged(session: Session) -> None:
    with pytest.raises(UserError, match="frame 1 has not been sent"):
        session.acknowledge(1)


def test_settings_render_the_same_pose_again(session: Session) -> None:
    session.pose(pose(1))
    take(session)
    session.change(5, (32, 18), RenderSettings(method=Method.PATH))
    order, job = take(session)
    assert (order.pose, order.settings, job.size, job.settings.method) == (1, 5, (32, 18), Method.PATH)
    session.acknowledge(2)
    session.change(6, None, None)
    assert take(session)[1].size == (32, 18)


def test_another_scene_waits_for_a_pose_of_its_own(session: Session) -> None:
    session.pose(pose(1))
    session.show(None)
    session.pose(pose(2))
    session.show(YARD)
    assert not session.due
    session.pose(pose(3))
    assert take(session)[1].scene == YARD


def test_settings_that_fail_are_not_tried_again_until_they_change(session: Session) -> None:
    session.pose(pose(1))
    session.failed(take(session)[0])
    session.pose(pose(2))
    assert not session.due
    session.change(1, None, RenderSettings(seed=2))
    for _ in range(WINDOW):  # the failed frame has left the window
        take(session)
        session.pose(pose(3))


def test_a_late_failure_does_not_block_newer_settings(session: Session) -> None:
    session.pose(pose(1))
    order, _ = take(session)
    session.change(1, None, RenderSettings(seed=2))
    session.failed(order)
    assert session.due


def test_a_lost_frame_is_tried_again_but_not_for_ever(session: Session) -> None:
    session.pose(pose(1))
    for _ in range(MAX_LOSSES - 1):
        assert session.lost(take(session)[0])
        assert session.due
    assert not session.lost(take(session)[0])
    assert not session.due


def test_a_delivered_frame_forgives_losses(session: Session) -> None:
    session.pose(pose(1))
    for _ in range(MAX_LOSSES):
        assert session.lost(take(session)[0])
        order, _ = take(session)
        session.delivered()
        session.acknowledge(order.frame)
        session.pose(pose(2))


def test_the_queue_time_counts_from_the_newest_change() -> None:
    clock = [0.0]
    session = Session(1, (64, 36), RenderSettings(), now=lambda: clock[0])
    session.show(HALL)
    session.pose(pose(1))
    clock[0] = 1.0
    session.pose(pose(2))
    clock[0] = 1.25
    assert take(session)[0].queue_ms == pytest.approx(250.0)
