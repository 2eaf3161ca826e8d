"""Writes docs/options.md from the models: every option, its default and limits. `python -m server.cli.reference`."""

import sys
from collections.abc import Iterable
from dataclasses import fields
from enum import Enum
from pathlib import Path
from typing import Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from gpu.sample_counts import ON_CPU, ON_CUDA, PATHS
from gpu.scene.animation.moment import Moment
from gpu.scene.import_options import ImportOptions
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.limits import SceneLimits
from gpu.settings import RenderSettings, Skips
from server.cli.options import flag_of, kind_of, limits_of
from server.settings import ServerSettings
from server.video.film_settings import FilmSettings

PAGE = Path(__file__).parents[2] / "docs" / "options.md"
# Of default sizes, the largest that divides one first.
BYTE_UNITS = ((2**30, "GiB"), (2**20, "MiB"))

HEAD = """# Options

Written by `make docs` from the settings' models (`gpu/settings.py`, `gpu/sample_counts.py`, `gpu/scene/`,
`server/settings.py`); do not edit. `lumenwalk render --help` and `lumenwalk serve --help` say the same.
"""
RENDER = """## Light and quality

Options of `lumenwalk render`. In the `settings` of a REST request each has the same name, written with underscores:
`--sp-clusters 4096` is `{"sp_clusters": 4096}`. The page shows the same settings in its panel. What a renderer does
with them is in [method.md](method.md).
"""
COUNTS = """### Counts chosen by device

`--samples` of the method `path` is {paths} on both.
"""
SKIPS = """### Skips

Each of these saves work, and is on unless told otherwise. `--no-skip NAME,NAME` switches some off; in a request,
`{"skip": {"NAME": false}}` does. [method.md](method.md#what-is-left-out) says what each one changes.
"""
MOMENT = """## A moment of an animation

Options of `lumenwalk render`. A film begins at that moment.
[formats.md](formats.md#animations) says what moves.
"""
READING = """## How a file is read

Options of `lumenwalk render`, `info` and `serve`, there for the served scene. In requests they are the parameters of an
upload and the `scene_options` of a render, and in the page, choices of its panel.
[formats.md](formats.md#up-units-places) says what is taken when they are not given.
"""
ENVIRONMENT = """## What is around the scene

Options of `lumenwalk render`, and of `lumenwalk serve` for all scenes. [formats.md](formats.md#environments) says which
pictures are read.
"""
FILM = """## Films

Options of `lumenwalk render` with `--path FILE`, and `film` of a request for one. [films.md](films.md) says what a path
is.
"""
SERVE = """## The service

Options of `lumenwalk serve`. Each can also stand in a TOML file, given by `--config FILE`, as `max_viewers = 8`, or in
the environment, as `LUMENWALK_MAX_VIEWERS=8`. Flags win over the environment, and that wins over the file.
"""
SCENES = """### Limits of scene files

In the TOML file under `[scene_limits]`, or in the environment as `LUMENWALK_SCENE_LIMITS__MAX_TRIANGLES=1000000`; they
have no flags. `lumenwalk render` and `lumenwalk info` use the defaults.
"""


def reference() -> str:
    """The whole page, as Markdown."""
    counts = ((flag_of(field.name), ON_CUDA, ON_CPU, field.name) for field in fields(ON_CUDA))
    parts = [
        HEAD,
        RENDER,
        _options(RenderSettings),
        COUNTS.format(paths=PATHS),
        _table(
            ("option", "GPU", "CPU"),
            ((f"`{flag}`", getattr(gpu, name), getattr(cpu, name)) for flag, gpu, cpu, name in counts),
        ),
        SKIPS,
        _table(
            ("name", "meaning"),
            ((f"`{name}`", field.description) for name, field in Skips.model_fields.items()),
        ),
        MOMENT,
        _options(Moment),
        READING,
        _options(ImportOptions),
        ENVIRONMENT,
        _options(EnvironmentOptions),
        FILM,
        _options(FilmSettings),
        SERVE,
        _options(ServerSettings),
        SCENES,
        _table(
            ("name", "default", "at most that many"),
            (
                (f"`{name}`", _default(name, field), field.description)
                for name, field in SceneLimits.model_fields.items()
            ),
        ),
    ]
    return "\n".join(parts)


def _options(model: type[BaseModel]) -> str:
    """A table of the fields of `model` that have an option."""
    rows = []
    for name, field in model.model_fields.items():
        kind, flag = kind_of(field), flag_of(name)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            continue
        option = f"`{flag}`, `--no-{flag[2:]}`" if kind is bool else f"`{flag}`"
        rows.append((option, _default(name, field), _values(field), field.description))
    return _table(("option", "default", "values", "meaning"), rows)


def _default(name: str, field: FieldInfo) -> str:
    value = field.get_default(call_default_factory=True, validated_data={})
    if value in (None, (), ""):
        return "by device" if hasattr(ON_CUDA, name) else ""
    if isinstance(value, tuple):
        return f"`{','.join(value)}`"
    if isinstance(value, bool):
        return "on" if value else "off"
    if "bytes" in name:
        for size, unit in BYTE_UNITS:
            if value % size == 0 and value >= size:
                return f"{value // size} {unit}"
    return f"`{value.value}`" if isinstance(value, Enum) else f"{value}"


def _values(field: FieldInfo) -> str:
    """What the field takes: the members of an enumeration, or the limits of a number."""
    kind = kind_of(field)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return ", ".join(f"`{member.value}`" for member in kind)
    if get_origin(kind) is Literal:
        return ", ".join(f"`{value}`" for value in get_args(kind))
    return limits_of(field)


def _table(head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def main(page: Path = PAGE) -> int:
    """Write the page."""
    page.write_text(reference())
    return 0


if __name__ == "__main__":
    sys.exit(main())
