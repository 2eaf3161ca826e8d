"""One picture into a file: the command `lumenwalk render`."""

import json
from pathlib import Path
from time import perf_counter

from server.cli.camera_argument import choose_camera
from server.cli.studio import ChosenScene, PictureOptions, Studio, warn_of_faults, write_picture
from server.images import check_output


def render_file(chosen: ChosenScene, path: Path, options: PictureOptions, *, camera: str, as_json: bool) -> None:
    """Render a scene into the image file `path`; with `as_json`, print the statistics on stdout.

    camera: as `choose_camera` reads it.
    Raises UserError for a scene, environment, edit, camera, device or file that is not there or not sound.
    """
    check_output(path)
    width, height = options.size
    started = perf_counter()
    scene = chosen.read()
    view = choose_camera(scene, camera, width / height)
    load_seconds = perf_counter() - started
    studio = Studio(scene, options)
    frame = studio.picture(view)
    studio.progress.end()
    write_picture(path, frame)
    stats = frame.stats
    warn_of_faults(stats.counts)
    if as_json:
        report = studio.report(path, load_seconds) | {
            "stage_ms": stats.stage_ms,
            "counts": stats.counts,
            "skips": stats.skips,
            "estimates": stats.estimates,
        }
        print(json.dumps(report, indent=2))
