"""What a walk with `photon-gather` leaves behind for its next frame: where it gathered light."""

from gpu.device_scene.upload import DeviceScene
from gpu.methods.view_state import ViewState
from gpu.sp.kept_centres import no_centres


class GatherViewState(ViewState):
    """A viewer with at most `centres` centres of shading clusters; keeps_centres: whether a frame has left some."""

    def __init__(self, device_scene: DeviceScene, size: tuple[int, int], centres: int) -> None:
        super().__init__(device_scene, size)
        self.centres = no_centres(centres, self.device)
        self.keeps_centres = False

    def forget(self) -> None:
        """As any viewer does: surfaces may have moved away from centres."""
        super().forget()
        self.keeps_centres = False
