"""The commands of `lumenwalk` and their options. Everything heavy is imported by the command that needs it."""

import re
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import NoReturn, TypeAlias

from gpu.errors import UserError
from gpu.scene.animation.moment import Moment
from gpu.scene.import_options import ImportOptions
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.load import SUFFIXES
from gpu.settings import Component, RenderSettings
from server.cli.options import add_options, flag_of, given_options, model_from
from server.importing import kept_imports
from server.render.worker_process import WorkerProcess
from server.settings import ServerSettings, load_settings
from server.video.film_settings import FILM_SUFFIX, FilmSettings

CAMERA_HELP = (
    'a camera of the scene by name or number (from 0), or "x,y,z:tx,ty,tz[:yfov]": the eye and what it looks at, in '
    "the file's own coordinates, and the vertical field of view in degrees (default 60); write --camera=-1,... when it "
    "starts with a minus (default 0)"
)
OUTPUT_HELP = (
    ".png or .jpg for display, .exr or .npy for linear radiance; with --path, .mp4, or the pattern of such pictures' "
    "names, as in frame-%%04d.png"
)
READING = "how the scene's file is read"
SCENE_HELP = f"a file ({' '.join(SUFFIXES)}) or the name of a built-in scene"


class _Parser(ArgumentParser):
    """argparse with this program's one-line errors."""

    def error(self, message: str) -> NoReturn:
        if option := re.fullmatch(r"argument (--[\w-]+).*: expected one argument", message):
            message += f"; one that starts with a minus is written {option[1]}=-1"
        raise UserError(message)


_Commands: TypeAlias = "_SubParsersAction[_Parser]"


def run(arguments: Sequence[str], worker: WorkerProcess | None = None) -> int:
    """Run one command and return its exit status; worker: one that runs already, for `serve`. UserError as is said."""
    if not arguments:
        raise UserError("give a command: serve, render, compare, info or warm; `lumenwalk --help` says what they do")
    options = parser(worker).parse_args(arguments)
    status: int = options.command(options)
    return status


def parser(worker: WorkerProcess | None = None) -> ArgumentParser:
    """The parser of all commands; worker: as of `run`."""
    lumenwalk = _Parser(prog="lumenwalk", description="Physically lit walks through a scene, in any browser.")
    lumenwalk.add_argument("--version", action="version", version=f"%(prog)s {version('lumenwalk')}")
    commands = lumenwalk.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)
    _add_serve(commands, worker)
    for add in (_add_render, _add_compare, _add_info, _add_warm):
        add(commands)
    return lumenwalk


def _add_serve(commands: _Commands, worker: WorkerProcess | None) -> None:
    parser = commands.add_parser("serve", help="serve scenes to browsers")
    parser.add_argument("--config", type=Path, metavar="FILE", help="a TOML file with settings by their names below")
    add_options(parser, ServerSettings, "service (or LUMENWALK_NAME in the environment; the limits of scenes only so)")
    add_options(parser, ImportOptions, READING)
    parser.set_defaults(command=partial(_serve, worker=worker))


def _serve(options: Namespace, worker: WorkerProcess | None) -> int:
    flags = given_options(options, ServerSettings)
    if given_options(options, ImportOptions):
        flags["scene_options"] = model_from(options, ImportOptions)
    settings = load_settings(options.config, flags)

    from server.serve import serve

    serve(settings, first=worker)
    return 0


def _add_render(commands: _Commands) -> None:
    parser = commands.add_parser("render", help="render a picture into a file, or a film along a camera path")
    parser.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    parser.add_argument("output", metavar="OUT", help=OUTPUT_HELP)
    parser.add_argument("--size", default="960x540", metavar="WxH", help="of the picture in pixels (default 960x540)")
    parser.add_argument("--camera", metavar="CAMERA", help=CAMERA_HELP)
    parser.add_argument("--path", type=Path, metavar="FILE", help="a film: the way of its camera, JSON (docs/films.md)")
    parser.add_argument("--device", metavar="NAME", help='"cpu" or "cuda:N" (default: the first GPU, else the CPU)')
    parser.add_argument(
        "--edit", type=Path, metavar="FILE", help="a JSON file of lights and materials that differ (docs/service.md)"
    )
    parser.add_argument("--json", action="store_true", help="print stage times, counts, skips and estimates as JSON")
    add_options(parser, RenderSettings, "light and quality")
    add_options(parser, Moment, "a moment of a scene that has animations")
    add_options(parser, ImportOptions, READING)
    add_options(parser, EnvironmentOptions, "what is around the scene")
    add_options(parser, FilmSettings, "a film, with --path")
    parser.set_defaults(command=_render)


def _render(options: Namespace) -> int:
    from gpu.scene.edits import NO_EDITS
    from server.cli.camera_argument import parse_size
    from server.cli.edit_file import read_edits

    settings, size, output = model_from(options, RenderSettings), parse_size(options.size), Path(options.output)
    reading, environment = model_from(options, ImportOptions), model_from(options, EnvironmentOptions)
    edits = NO_EDITS if options.edit is None else read_edits(options.edit)
    edits = edits.model_copy(update=model_from(options, Moment).model_dump(exclude_unset=True))
    film = model_from(options, FilmSettings)
    if options.path is None:
        if output.suffix.lower() == FILM_SUFFIX:
            raise UserError(f"{output}: is a film; give the way of its camera by --path FILE")
        if given := given_options(options, FilmSettings):
            raise UserError(f"{flag_of(next(iter(given)))}: is of a film; give the way of its camera by --path FILE")
    elif options.camera is not None:
        raise UserError("--camera: is of one picture; leave it out, or --path")

    with kept_imports():
        from server.cli.film import is_numbered, render_film
        from server.cli.still import render_file
        from server.cli.studio import ChosenScene, PictureOptions

    if options.path is None and is_numbered(output):
        raise UserError(f"{output}: numbers a film's pictures; give the way of its camera by --path FILE")
    chosen = ChosenScene(options.scene, reading, environment, edits, options.edit)
    pictures = PictureOptions(size, options.device, settings)
    if options.path is None:
        render_file(chosen, output, pictures, camera=options.camera or "0", as_json=options.json)
    else:
        render_film(chosen, output, pictures, path=options.path, film=film, as_json=options.json)
    return 0


def _add_compare(commands: _Commands) -> None:
    parser = commands.add_parser(
        "compare",
        help="measure a picture against a reference",
        description="MSE (clipped at the reference's 99th percentile), relMSE, mean HDR-FLIP and energy of A against B."
        "\nBoth are linear: .npy, .exr, or an .npz with arrays `full` and `direct`.",
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("render", metavar="A", help="the picture")
    parser.add_argument("reference", metavar="B", help="the reference")
    parser.add_argument(
        "--component",
        choices=[component.value for component in Component],
        default=Component.FULL.value,
        help="what to take from an .npz (indirect is full - direct); other files are taken as they are (default full)",
    )
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON")
    parser.set_defaults(command=_compare)


def _compare(options: Namespace) -> int:
    from server.cli.reports import report_errors

    return report_errors(options.render, options.reference, Component(options.component), as_json=options.json)


def _add_info(commands: _Commands) -> None:
    parser = commands.add_parser("info", help="say what is in a scene")
    parser.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    parser.add_argument("--json", action="store_true", help="print it as JSON")
    add_options(parser, ImportOptions, READING)
    parser.set_defaults(command=_info)


def _info(options: Namespace) -> int:
    from server.cli.reports import report_scene

    report_scene(options.scene, model_from(options, ImportOptions), as_json=options.json)
    return 0


def _add_warm(commands: _Commands) -> None:
    parser = commands.add_parser("warm", help="compile the kernels of scenes ahead, so that nobody waits for it")
    parser.add_argument(
        "scenes", metavar="SCENE", nargs="*", help=f"{SCENE_HELP}; all built-in ones when none is given"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--device", metavar="NAME", help='"cpu" or "cuda:N" (default: the first GPU, else the CPU)')
    where.add_argument(
        "--architecture",
        metavar="SM",
        action="append",
        type=int,
        help="of GPUs that need not be here: ten times their compute capability, such as 90; may be given again",
    )
    parser.add_argument("--general", action="store_true", help="also what other scenes begin with on a GPU meanwhile")
    add_options(parser, RenderSettings, "light and quality")
    add_options(parser, ImportOptions, READING)
    parser.set_defaults(command=_warm)


def _warm(options: Namespace) -> int:
    settings, reading = model_from(options, RenderSettings), model_from(options, ImportOptions)

    with kept_imports():
        from server.cli.warm import warm_scenes, warm_scenes_for

    what = tuple(options.scenes), reading, settings
    if options.architecture is None:
        warm_scenes(*what, options.device, general=options.general)
    else:
        warm_scenes_for(*what, tuple(options.architecture), general=options.general)
    return 0
