"""What a render request says, for stills and for jobs alike."""

from math import ceil

from pydantic import ConfigDict, Field

from gpu.scene.edits import NO_EDITS, SceneEdits
from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from server.render.turns import samples_a_turn
from server.wire.browser import Message, SceneId, Size
from server.wire.cameras import CameraChoice, view_of
from server.wire.worker import CameraSpec, Output, Render, SceneRef

# Samples a pixel of one frame of a method that refines by samples, at most.
SAMPLES_A_FRAME = 64


class PictureRequest(Message):
    """Where pictures are of, and how they are rendered; what is left out gets its default."""

    scene: SceneId | None = Field(default=None, description="scene id; the served scene when not given")
    scene_options: ImportOptions | None = Field(
        default=None, description="how its file is read; as the service does when not given"
    )
    edits: SceneEdits | None = Field(
        default=None, description="all that differs from its file; as all who look see it when not given"
    )
    size: Size = Field(default=(1280, 720), description="width and height [px]")
    settings: RenderSettings = Field(
        default=RenderSettings(),
        description="method and quality; `frames` are averaged (1 when not given), and so are frames of fewer "
        "samples where those asked for would take the device from others for long",
    )

    def frames(self) -> tuple[int, RenderSettings]:
        """How many frames the picture is the mean of, each a turn of its own, and the settings of each."""
        settings, frames = self.settings, self.settings.frames or 1
        if settings.samples is not None:
            most = samples_a_turn(settings, self.size)
            pieces = ceil(
                settings.samples / (min(most, SAMPLES_A_FRAME) if settings.method.refines_by_samples else most)
            )
            settings = settings.model_copy(update={"samples": ceil(settings.samples / pieces)})
            frames *= pieces
        return frames, settings.model_copy(update={"frames": None})


class RenderRequest(PictureRequest):
    """A still; what is left out gets its default."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"size": [64, 36]},
                {
                    "camera": {"position": [0.0, 1.0, 3.0], "target": [0.0, 1.0, 0.0], "yfov_degrees": 45.0},
                    "size": [64, 36],
                    "settings": {"method": "path", "samples": 4},
                },
            ]
        }
    )

    camera: CameraChoice = Field(default=0, description="one of the scene's by index or name, or one of your own")

    def view(self) -> CameraSpec:
        """The camera as the worker takes it."""
        return view_of(self.camera)

    def weight(self) -> int:
        """The work of the picture, in frames of as many samples as are usual at most."""
        return (self.settings.frames or 1) * ceil((self.settings.samples or 1) / SAMPLES_A_FRAME)

    def render(self, viewer: int, scene: SceneRef, output: Output, edits: SceneEdits = NO_EDITS) -> Render:
        """The order to the worker for one frame of it; edits: what differs from the scene's file."""
        return Render(viewer, scene, self.view(), self.size, self.frames()[1], output, edits=edits)
