"""A scene that a command names, brought onto a device, and pictures of it, each refined as its settings ask for."""

import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.renderer import Renderer
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.lighting.environment import with_environment
from gpu.scene.lighting.environment_options import NO_ENVIRONMENT, EnvironmentOptions
from gpu.scene.types import Camera, Scene
from gpu.settings import RenderSettings
from gpu.warm_up import warm_up_still
from server.cli.reading import read_scene
from server.images import DISPLAY_FORMATS, encode_image, write_atomic

FAULTS = ("nonfinite", "unassigned")  # of pixels, that are warned of
_OF_OPTIONS = ("animation:", "time:")  # how errors begin of what has options of its own


@dataclass(frozen=True)
class ChosenScene:
    """A built-in scene's name or a file, how that is read, what is around it, and what differs from the file;
    edit_file: that says so.
    """

    source: str
    reading: ImportOptions = DEFAULT_OPTIONS
    environment: EnvironmentOptions = NO_ENVIRONMENT
    edits: SceneEdits = NO_EDITS
    edit_file: Path | None = None

    def read(self) -> Scene:
        """The scene with its edits, as `read_file`. Raises UserError for an edit that cannot be, too."""
        return self.edited(self.read_file(), self.edits)

    def edited(self, scene: Scene, edits: SceneEdits) -> Scene:
        """`scene` with `edits`; raises UserError for one that cannot be, which names the file that has it."""
        try:
            return edited(scene, edits)
        except UserError as error:
            if self.edit_file is None or str(error).startswith(_OF_OPTIONS):
                raise
            raise UserError(f"--edit: {self.edit_file}: {error}") from None

    def read_file(self) -> Scene:
        """The scene of the file; notes on it go to stderr. Raises UserError for one that is not there or not sound."""
        scene = with_environment(read_scene(self.source, self.reading), self.environment)
        for sentence in (*scene.report.ignored, *scene.report.notes):
            print(f"lumenwalk: note: {sentence}", file=sys.stderr)
        return scene


@dataclass(frozen=True)
class PictureOptions:
    """size: width and height [px]; device: None takes the best there is."""

    size: tuple[int, int]
    device: str | None
    settings: RenderSettings

    @property
    def frames(self) -> int:
        """That a picture is the mean of."""
        return self.settings.frames or 1


class Studio:
    """A scene on a device and a renderer of it; raises UserError for a device that is not there or cannot hold it."""

    def __init__(self, scene: Scene, options: PictureOptions) -> None:
        began = perf_counter()
        self._scene, self._options = scene, options
        self._device_scene = DeviceScene(scene, options.device)
        self.progress = Progress()
        self.progress("compiling kernels, which the first time takes a minute", 0.0)
        warm_up_still(self._device_scene, options.settings, options.frames)
        self._renderer = Renderer(self._device_scene, options.size, options.settings, progress=self.progress)
        self._accumulation = Accumulation(options.size[0] * options.size[1], self._device_scene.device)
        self._build_seconds, self._render_seconds = perf_counter() - began, 0.0

    def show(self, scene: Scene) -> None:
        """Have later pictures show `scene`, which is the one before with other edits."""
        began = perf_counter()
        self._scene, self._device_scene = scene, self._device_scene.edited(scene)
        options = self._options
        self._renderer = Renderer(self._device_scene, options.size, options.settings, progress=self.progress)
        self._build_seconds += perf_counter() - began

    def picture(self, camera: Camera, part: tuple[int, int] = (0, 1)) -> Frame:
        """The mean of the frames from `camera`, valid until the next picture; nothing of earlier pictures is in it.

        part: which picture it is, from 0, and of how many, for the progress.
        """
        began = perf_counter()
        number, count = part
        frames, what = self._options.frames, "averaging frames" if count == 1 else f"picture {number + 1} of {count}"
        self._accumulation.restart()
        frame = self._renderer.render(camera, self._accumulation)
        while self._accumulation.samples < frames:
            self.progress(what, (number + self._accumulation.samples / frames) / count)
            frame = self._renderer.render(camera, self._accumulation)
        if count > 1:
            self.progress(what, (number + 1) / count)
        self._render_seconds += perf_counter() - began
        return frame

    def report(self, output: object, load_seconds: float) -> dict[str, Any]:
        """What every report says of pictures, in JSON's types."""
        seconds = {"load": load_seconds, "build": self._build_seconds, "render": self._render_seconds}
        return {
            "scene": self._scene.name,
            "output": str(output),
            "size": self._options.size,
            "device": str(self._device_scene.device),
            "settings": self._options.settings.model_dump(mode="json"),
            "seconds": seconds,
        }


class Progress:
    """What a renderer is at, as one changing line on stderr; nothing where that is not a terminal."""

    def __init__(self) -> None:
        self._shown = sys.stderr.isatty()

    def __call__(self, what: str, fraction: float) -> None:
        """Show that `fraction`, 0 to 1, of `what` is done."""
        if self._shown:
            print(f"\r\x1b[K{what} {fraction:4.0%}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Clear the line."""
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def write_picture(path: Path, frame: Frame) -> None:
    """A frame as the image file that the name asks for."""
    display = path.suffix.lower() in DISPLAY_FORMATS
    data = encode_image(frame.pixels() if display else None, None if display else frame.radiance(), path.suffix)
    write_atomic(path, data)


def warn_of_faults(counts: dict[str, int]) -> None:
    """Say on stderr how many pixels are wrong, if any are."""
    for what in FAULTS:
        if counts.get(what, 0):
            print(f"lumenwalk: warning: {counts[what]} {what} pixels", file=sys.stderr)
