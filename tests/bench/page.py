"""The page of results: what was aimed at and what was reached, then each part's plots and tables.

Every figure is computed from the rows of OUT/*.json; what was not measured is named. OUT/tried.md, where there is one,
says in words and figures of its own what was tried on the way.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from tests.bench import floor_tables, tables
from tests.bench.goals import Goal, goals
from tests.bench.store import Row
from tests.bench.suite import Suite


@dataclass(frozen=True)
class Section:
    """One part on the page: its heading, how to read it, its plots by pattern with captions, and its tables."""

    part: str
    title: str
    text: str
    plots: dict[str, str]
    tables: tuple[Callable[[list[Row]], str], ...] = ()


SECTIONS = (
    Section(
        "sweep",
        "Time and error of indirect light",
        "Total error is against path tracing. Clustering error is against `exact-vpl` with the same VPLs, their disks "
        "as the row's own clusters make them, and neither picture has near-field light, in which clusters have no "
        "part. The default settings come first, then the 2022 paper's three settings beside what it reports "
        "(conference room, on an RTX 2060 laptop). *Indirect* adds up the medians of all stages but "
        "primary rays and display. Frames begin from nothing, unless they are said to be in motion: the camera then "
        "turns by half a degree from frame to frame, which keep SP clusters, what those see and the light that rays "
        "found; stages in brackets.",
        {
            "stages": "each stage's time",
            "error-time-*": "error over time; stars, pluses and crosses are the paper's figures",
            "grid-*": "time and clustering error over both kinds of clusters",
            "fuzziness": "clustering error and time over fuzziness",
            "vpls": "errors and time over the number of VPLs",
        },
        (tables.default_table, tables.motion_table, tables.stages_table, tables.paper_table),
    ),
    Section(
        "floors",
        "What is left to the floors",
        "A stage cannot be faster than the most that it must do of one thing, over the rate at which this machine does "
        "that thing alone, and its launches on top. Rays are timed with neighbouring threads on neighbouring points, "
        "bytes by a large copy, multiply-adds in registers, launches in a graph. Each byte counts once, as if caches "
        "were perfect. Cells are measured / floor (ratio).",
        {"floors": "time of each stage; the solid part is its floor"},
        (floor_tables.floors_table, floor_tables.rates_table, lambda rows: floor_tables.terms_table(rows[0])),
    ),
    Section(
        "decompose",
        "Bias and noise",
        "relMSE told apart by several seeds: bias stays when seeds are averaged, noise differs between them.",
        {"error-parts": "bias and noise of VPLs and of clustering"},
        (tables.decompose_table,),
    ),
    Section(
        "temporal",
        "Flicker",
        "Mean absolute change between consecutive frames of a walk, over the mean radiance; flicker is what goes "
        "beyond the change of `exact-vpl` with the same VPLs.",
        {"flicker": "change between the frames of a walk"},
        (tables.temporal_table,),
    ),
    Section(
        "skips",
        "What is not done",
        "Each switch the other way, one at a time, with all light. Gain is the share of the frame's time that the "
        "switch saves as it comes.",
        {},
        (tables.skips_table,),
    ),
    Section(
        "still",
        "A view that rests",
        "All light, against path tracing spread over the pixels: after one frame, after a second, and at the end. "
        "What is beyond the reference's noise is measured with a second picture by path tracing, of other paths.",
        {"rest": "relMSE over the time that a view has rested, beyond the reference's noise; dotted: with it"},
        (tables.still_table,),
    ),
    Section(
        "targets",
        "Wanted time or error",
        "Counts of clusters are chosen for a wanted frame time or clustering error (MSE), while the camera sways to "
        "and fro. Wanted times are multiples of what the default counts take, wanted errors lie between those that the "
        "fewest and the most counts have on the walk. Of errors a few frames are measured, against `exact-vpl` with "
        "the same VPLs. above: frames more than 10 % above the target; below at the fewest counts: frames more than "
        "10 % below it that have the fewest clusters there are; tries: renders of a frame, more than one where it is "
        "seen to have too large an error; stages: what those of all tries take, probes of the error, too; with the "
        "host: from a frame's call to its return, of which wanted times are; pairs: of clusters; passes: of an SP's "
        "rays that correct its light.",
        {"targets": "what frames take or have over what is wanted, while the camera sways; green: within 10 %"},
        (tables.targets_table,),
    ),
    Section(
        "peers",
        "Beside path tracers",
        "All light: when path tracing here and by Mitsuba 3 reach the error of each row.",
        {"peers": "relMSE of all light over time"},
        (tables.peers_table,),
    ),
    Section(
        "growth",
        "Growth",
        "One of three grows, the others stay; the slope is the power p of time ∝ xᵖ.",
        {"growth": "growth of time"},
        (tables.growth_table,),
    ),
    Section(
        "pictures",
        "Pictures and where they are wrong",
        "Indirect light, the path-traced reference, and maps of relative squared error.",
        {"pictures-*": "picture, reference and error maps"},
    ),
    Section(
        "walk",
        "Frames a second",
        "Whole frames with a device's default settings, the camera turning, display included, encoding not.",
        {},
        (tables.walk_table,),
    ),
)


def page(rows: dict[str, list[Row]], folder: str, images: Iterable[str], tried: str = "") -> str:
    """The page's text. folder: of the images, as links reach it; images: names of the files there.

    tried: what was tried to get there, and what that gave, in Markdown.
    """
    aims, names = list(goals(rows)), sorted(images)
    parts = ["# Results", HEAD, "## Goals", tables.goals_table(aims), "## What falls short", shortfalls(aims, rows)]
    for section in SECTIONS:
        parts.append(f"## {section.title}")
        if not rows.get(section.part):
            parts.append(f"**Not measured.** `python -m tests.bench {section.part}` does.")
            continue
        parts.append(section.text)
        parts += [make(rows[section.part]) for make in section.tables]
        for pattern, caption in section.plots.items():
            found = [name for name in names if Path(Path(name).stem).match(pattern)]
            parts += [f"![{_caption(name, pattern, caption)}]({folder}/{name})" for name in found]
    parts += ["## What was tried", tried.strip()] if tried else []
    parts += ["## Elsewhere", ELSEWHERE, "## Commands", COMMANDS, "## Measured on", measured_on(rows)]
    return "\n\n".join(parts) + "\n"


HEAD = """\
Written by `python -m tests.bench page` of what the suite measured; do not edit. The same scenes, settings and commands
give these figures again. Times are medians, with the 5th to 95th percentile in brackets. Rows of earlier commits stay
until they are measured again; which those are is said [at the end](#measured-on)."""

ELSEWHERE = """\
Stability (scale and place of a scene, same bits for the same seed, furnaces, leaks, broken meshes, sums in float32) is
tested by `tests/stability`, errors of small renders, which must not rise, by `python -m tests.bench gate`; `make test`
runs both. The service under load is measured by `python -m tests.load`; its figures are in docs/figures.md."""

COMMANDS = """\
    python -m tests.bench survey --scenes DIR --references DIR --out RESULTS    # about twenty minutes of an H100
    python -m tests.bench --scenes DIR --references DIR --out RESULTS           # every part, all scenes: hours
    python -m tests.bench plots page --out RESULTS --page docs/results.md       # this page

A folder of scenes has NAME.glb, one of references NAME.npz with path-traced pictures; without them the built-in scenes
are measured, whose references are traced first."""


def measured_on(rows: dict[str, list[Row]]) -> str:
    """What the rows of each part were measured on, and of which commit."""
    lines = []
    for section in SECTIONS:
        found = Counter(tuple(row["environment"].items()) for row in rows.get(section.part, []))
        for items, count in found.items():
            there = dict(items)
            system = f"Warp {there['warp']}, Python {there['python']}, {there['cores']} CPU cores"
            lines.append([section.part, str(count), there["device"], system, there["commit"][:12]])
    return tables.table(["part", "rows", "device", "with", "commit"], lines)


def shortfalls(aims: list[Goal], rows: dict[str, list[Row]]) -> str:
    """A line for each goal that is missed, with every scene that misses it, and for each part that was not measured."""
    lines = []
    for goal in aims:
        if missed := goal.missed():
            values = (f"{name} {tables.number(value)}{_distance(goal, value)}" for name, value in missed)
            lines.append(f"- {goal.what}: {', '.join(values)}")
        elif not goal.values:
            lines.append(f"- {goal.what}: not measured")
    lines += [f"- {section.title}: not measured" for section in SECTIONS if not rows.get(section.part)]
    return "\n".join(lines) or "Nothing that was measured."


def _distance(goal: Goal, value: float) -> str:
    """How far a value is from good enough, unless it is nothing at all."""
    return f" ({tables.number(100.0 * (goal.excess(value) - 1.0))} % off)" if value > 0.0 else ""


def _caption(name: str, pattern: str, caption: str) -> str:
    """The caption, with what the pattern's star stands for in front."""
    begin, star, _ = pattern.partition("*")
    return f"{Path(name).stem.removeprefix(begin)}: {caption}" if star else caption


def run(suite: Suite) -> None:
    """The part of the command line."""
    folder = suite.images_folder
    images = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    suite.page.parent.mkdir(parents=True, exist_ok=True)
    suite.page.write_text(page(suite.measured(), folder.name, images, suite.tried()))
    print(f"page: {suite.page}")
