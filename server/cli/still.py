"""One picture into a file: the command `lumenwalk render`."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.environment import with_environment
from gpu.scene.environment_options import NO_ENVIRONMENT, EnvironmentOptions
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.settings import RenderSettings
from server.cli.camera_argument import choose_camera
from server.cli.reading import read_scene
from server.images import DISPLAY_FORMATS, check_output, encode_image, write_atomic


@dataclass(frozen=True)
class ChosenScene:
    """A built-in scene's name or a file, how that is read, what is around it, and what differs from the file."""

    source: str
    reading: ImportOptions = DEFAULT_OPTIONS
    environment: EnvironmentOptions = NO_ENVIRONMENT
    edits: SceneEdits = NO_EDITS


def render_file(
    chosen: ChosenScene,
    path: Path,
    *,
    size: tuple[int, int],
    camera: str,
    device: str | None,
    settings: RenderSettings,
    as_json: bool,
) -> None:
    """Render a scene into the image file `path`; with `as_json`, print the statistics on stdout.

    size: width and height [px]; camera: as `choose_camera` reads it; device: None takes the best there is.
    Raises UserError for a scene, environment, edit, camera, device or file that is not there or not sound.
    """
    suffix = check_output(path)
    width, height = size
    started = perf_counter()
    scene = with_environment(read_scene(chosen.source, chosen.reading), chosen.environment)
    for sentence in (*scene.report.ignored, *scene.report.notes):
        print(f"lumenwalk: note: {sentence}", file=sys.stderr)
    scene = edited(scene, chosen.edits)
    view = choose_camera(scene, camera, width / height)
    loaded = perf_counter()
    device_scene = DeviceScene(scene, device)
    progress = Progress()
    renderer = Renderer(device_scene, size, settings, progress=progress)
    built = perf_counter()
    accumulation = Accumulation(width * height, device_scene.device)
    frame = renderer.render(view, accumulation)
    while accumulation.samples < (settings.frames or 1):
        progress("averaging frames", accumulation.samples / (settings.frames or 1))
        frame = renderer.render(view, accumulation)
    rendered = perf_counter()
    progress.end()
    display = suffix in DISPLAY_FORMATS
    data = encode_image(frame.pixels() if display else None, None if display else frame.radiance(), suffix)
    write_atomic(path, data)
    stats = frame.stats
    for what in ("nonfinite", "unassigned"):
        if stats.counts.get(what, 0):
            print(f"lumenwalk: warning: {stats.counts[what]} {what} pixels", file=sys.stderr)
    if as_json:
        report: dict[str, Any] = {
            "scene": scene.name,
            "output": str(path),
            "size": size,
            "device": str(device_scene.device),
            "settings": settings.model_dump(mode="json"),
            "seconds": {"load": loaded - started, "build": built - loaded, "render": rendered - built},
            "stage_ms": stats.stage_ms,
            "counts": stats.counts,
            "skips": stats.skips,
            "estimates": stats.estimates,
        }
        print(json.dumps(report, indent=2))


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
