"""A film along a camera path: one video file, or numbered pictures."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from pydantic import ValidationError

from gpu.errors import UserError
from gpu.film.frame import Frame
from gpu.scene.camera_path import CameraPath
from gpu.scene.formats.text import without_mark
from gpu.scene.types import Scene
from server.cli.studio import FAULTS, ChosenScene, PictureOptions, Studio, warn_of_faults, write_picture
from server.images import check_folder, check_output
from server.scenes.view_camera import camera_path
from server.video.film_file import FilmFile, check_film
from server.video.film_settings import FILM_SUFFIX, FilmSettings
from server.video.playing import played
from server.wire.browser import describe
from server.wire.camera_path import CameraPathSpec
from server.wire.worker import AlongPath

MAX_PATH_BYTES = 2**20
_NUMBER = re.compile(r"%(?:0(\d))?d")


def is_numbered(output: Path) -> bool:
    """Whether a file's name has the place of a number, as of many pictures."""
    return _NUMBER.search(output.name) is not None


@dataclass(frozen=True)
class PictureFiles:
    """Pictures numbered from 1; pattern: a file with the place of the number in its name, such as frame-%04d.png."""

    pattern: Path

    def check(self) -> None:
        """UserError where the pattern has no place for one number, or the pictures cannot be written there."""
        if len(_NUMBER.findall(self.pattern.name)) != 1 or "%" in _NUMBER.sub("", str(self.pattern)):
            raise UserError(
                f"{self.pattern}: is one file for the many pictures of --path; "
                f"number them, as in frame-%04d.png, or write a film{FILM_SUFFIX}"
            )
        check_output(self.file(1))

    def file(self, number: int) -> Path:
        """Of a picture."""
        return self.pattern.with_name(
            _NUMBER.sub(lambda place: str(number).zfill(int(place[1] or 0)), self.pattern.name)
        )


def read_path(file: Path) -> CameraPathSpec:
    """The camera path in a JSON file; raises UserError that names the file and the field that is wrong."""
    try:
        with file.open("rb") as source:
            content = source.read(MAX_PATH_BYTES + 1)
    except OSError as error:
        raise UserError(f"--path: {file}: cannot be read: {error.strerror}") from None
    if len(content) > MAX_PATH_BYTES:
        raise UserError(f"--path: {file}: is larger than the {MAX_PATH_BYTES} bytes of a camera path")
    try:
        return CameraPathSpec.model_validate_json(without_mark(content))
    except ValidationError as error:
        raise UserError(f"--path: {file}: {describe(error)}") from None


def _way(file: Path, scene: Scene, view: AlongPath, size: tuple[int, int]) -> CameraPath:
    """The way of a camera in a scene; raises UserError that names the file and the keyframe that is wrong."""
    try:
        return camera_path(scene, view, size)
    except UserError as error:
        raise UserError(f"--path: {file}: {error}") from None


def is_film(output: Path) -> bool:
    """Whether a file is for a film, by its name."""
    return output.suffix.lower() == FILM_SUFFIX


def _check(output: Path, size: tuple[int, int], film: FilmSettings) -> None:
    """UserError where no film or no pictures can be written to `output`, before any is rendered."""
    if is_film(output):
        check_film(size, film.codec)
        check_folder(output)
    else:
        PictureFiles(output).check()


@contextmanager
def _writer(output: Path, size: tuple[int, int], film: FilmSettings) -> Iterator[Callable[[int, Frame], None]]:
    """What writes the picture of an index, from 0: into the video file `output`, or into a file of its own."""
    if is_film(output):
        with FilmFile(output, size, film) as video:
            yield lambda _, frame: video.add(frame.pixels())
    else:
        files = PictureFiles(output)
        yield lambda index, frame: write_picture(files.file(index + 1), frame)


def render_film(
    chosen: ChosenScene,
    output: Path,
    options: PictureOptions,
    *,
    path: Path,
    film: FilmSettings,
    as_json: bool,
) -> None:
    """Render a film along the path that a file says into the video file `output`, or into pictures of which that is
    the pattern.

    Every picture is a still's: refined from nothing, so that nothing of the one before it is seen in it. With
    `as_json`, statistics are printed on stdout. Raises UserError for a scene, environment, edit, camera, device or
    file that is not there or not sound.
    """
    views = read_path(path).views(film.fps)
    _check(output, options.size, film)
    started = perf_counter()
    scene = chosen.read_file()
    shown, edits = chosen.edited(scene, chosen.edits), chosen.edits
    animations = {} if scene.motion is None else {it.id: it.seconds for it in scene.motion.animations}
    way = _way(path, shown, views[0], options.size)
    load_seconds = perf_counter() - started
    studio, faults, writing = Studio(shown, options), Counter[str](), 0.0
    with _writer(output, options.size, film) as write:
        for index, view in enumerate(views):
            moment = played(chosen.edits, animations, film.play, view.time - views[0].time)
            if moment != edits:
                edits, shown = moment, chosen.edited(scene, moment)
                studio.show(shown)
                way = _way(path, shown, view, options.size)
            frame = studio.picture(way.at(view.time), (index, len(views)))
            faults.update({what: frame.stats.counts.get(what, 0) for what in FAULTS})
            began = perf_counter()
            write(index, frame)
            writing += perf_counter() - began
    studio.progress.end()
    warn_of_faults(faults)
    if as_json:
        report = studio.report(output, load_seconds)
        report["seconds"]["write"] = writing
        told = {"pictures": len(views), "fps": film.fps, "frames": options.frames, "counts": dict(faults)}
        print(json.dumps(report | told, indent=2))
