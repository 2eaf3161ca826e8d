"""What one viewer wants and has been sent: the newest pose wins, and few frames are unacknowledged. No I/O here."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.messages import Placed, Render, SceneRef
from server.protocol import WINDOW, Pose

MAX_LOSSES = 3


@dataclass(frozen=True)
class Order:
    """A frame that is being rendered: its id, what it shows, and how long that had waited [ms]."""

    frame: int
    pose: int
    settings: int
    queue_ms: float


class Session:
    """The state of one viewer.

    `scene` is None until one is open. A frame is due when there is something new to show, room in the window, and
    nothing has shown that these settings cannot be rendered.
    """

    def __init__(
        self, viewer: int, size: tuple[int, int], settings: RenderSettings, now: Callable[[], float] = monotonic
    ) -> None:
        self.viewer = viewer
        self.scene: SceneRef | None = None
        self._size = size
        self._settings = settings
        self._settings_id = 0
        self._pose: Pose | None = None
        self._now = now
        self._changed_at = 0.0
        self._fresh = False  # something changed since the last frame was ordered
        self._blocked = False  # these settings failed: wait for others
        self._losses = 0  # workers lost in a row while rendering for this viewer
        self._last_frame = 0
        self._unacknowledged: set[int] = set()  # frames being rendered, sent, or shown without an acknowledgement

    @property
    def due(self) -> bool:
        """Whether a frame should be rendered."""
        shown = self.scene is not None and self._pose is not None and self._fresh
        return shown and not self._blocked and len(self._unacknowledged) < WINDOW

    def pose(self, pose: Pose) -> None:
        """The viewer has moved. Poses are dropped while no scene is open: they are meant for the last one."""
        if self.scene is not None:
            self._pose = pose
            self._touch()

    def change(self, settings_id: int, size: tuple[int, int] | None, settings: RenderSettings | None) -> None:
        """The viewer wants other frames from now on; what is None stays."""
        self._settings_id = settings_id
        self._size = size or self._size
        self._settings = settings or self._settings
        self._blocked = False
        self._losses = 0
        self._touch()

    def show(self, scene: SceneRef | None) -> None:
        """From now on this scene, from a pose that is yet to come; None while the next one is being opened."""
        self.scene = scene
        self._pose = None
        self._blocked = False
        self._losses = 0

    def acknowledge(self, frame: int) -> None:
        """The viewer is done with this frame and all before it; UserError when it cannot have it."""
        if frame > self._last_frame:
            raise UserError(f"ack.frame: frame {frame} has not been sent; the last one was {self._last_frame}")
        self._unacknowledged = {sent for sent in self._unacknowledged if sent > frame}

    def take(self) -> tuple[Order, Render] | None:
        """The newest view as a job for the worker, or None when no frame is due any more."""
        if not self.due or self.scene is None or self._pose is None:
            return None
        self._fresh = False
        self._last_frame += 1
        self._unacknowledged.add(self._last_frame)
        waited = 1e3 * (self._now() - self._changed_at)
        order = Order(self._last_frame, self._pose.id, self._settings_id, waited)
        view = Placed(self._pose.matrix, self._pose.yfov)
        return order, Render(self.viewer, self.scene, view, self._size, self._settings, "jpeg")

    def delivered(self) -> None:
        """A frame was rendered."""
        self._losses = 0

    def failed(self, order: Order) -> None:
        """A frame could not be rendered: none is tried again before the settings change."""
        self._unacknowledged.discard(order.frame)
        self._blocked = order.settings == self._settings_id

    def lost(self, order: Order) -> bool:
        """The worker died with a frame: it is tried again; False when that happened too often with these settings."""
        self._unacknowledged.discard(order.frame)
        self._fresh = True
        self._losses += 1
        self._blocked = self._losses >= MAX_LOSSES
        return not self._blocked

    def _touch(self) -> None:
        self._fresh = True
        self._changed_at = self._now()
