"""Tables of the rows of each part, in Markdown."""

from collections.abc import Iterable

from tests.bench import paper
from tests.bench.figures import spread, time_to_equal_error
from tests.bench.goals import STILL_SECONDS, WITHIN, Goal
from tests.bench.rows import (
    GROWTH_AXES,
    default_rows,
    growth_series,
    indirect_ms,
    method_text,
    motion_rows,
    points_of,
    scenes_of,
    setting_rows,
    slopes,
    targeted,
    within,
)
from tests.bench.store import Row


def table(head: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    head = list(head)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [head, ["---"] * len(head), *lines])


def number(value: float | None) -> str:
    """Three figures, or a dash where there is none."""
    if value is None:
        return "–"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def spread_text(times: dict[str, float]) -> str:
    """Median and, in brackets, 5th to 95th percentile."""
    return f"{number(times['median'])} ({number(times['p5'])}–{number(times['p95'])})"


def goals_table(goals: list[Goal]) -> str:
    """Each goal, what is worst, how many reach it, and the verdict."""
    lines = []
    for goal in goals:
        wanted = f"{number(goal.low)} to {number(goal.high)}" if goal.low else f"≤ {number(goal.high)}"
        worst = goal.worst()
        shown = f"{number(worst[1])} ({worst[0]})" if worst else "–"
        reached = f"{len(goal.reached())} of {len(goal.values)}" if goal.values else "–"
        verdict = goal.verdict if goal.verdict == "met" else f"**{goal.verdict}**"
        lines.append([goal.what, f"{wanted} {goal.unit}".rstrip(), shown, reached, verdict])
    return table(["goal", "wanted", "worst", "reached by", "verdict"], lines)


def default_table(rows: list[Row]) -> str:
    """Times and errors of the default settings, a line a scene."""
    head = ["scene", "indirect [ms]", "whole frame [ms]", "relMSE", "MSE", "HDR-FLIP", "energy"]
    lines = []
    for row in default_rows(rows):
        total, clustering = row["errors"]["total"], row["errors"].get("clustering", {})
        times = [number(indirect_ms(row)), spread_text(row["frame_ms"])]
        errors = [number(total[metric]) for metric in ("rel_mse", "mse", "flip", "energy")]
        errors += [number(clustering.get(metric)) for metric in ("mse", "rel_mse")]
        nonfinite = sum(errors["nonfinite"] for errors in row["errors"].values())
        size = "×".join(map(str, row["size"]))
        lines.append([f"{row['scene']} {size}", *times, *errors, str(nonfinite), str(row["counts"]["unassigned"])])
    return table([*head, "clustering MSE", "relMSE", "non-finite", "without a cluster"], lines)


def motion_table(rows: list[Row]) -> str:
    """Times and errors of the default settings while the camera turns, a line a scene."""
    head = ["scene, in motion", "indirect [ms]", "whole frame [ms]", "relMSE", "MSE", "energy", "clustering MSE"]
    lines = []
    for row in motion_rows(default_rows(rows)):
        total, clustering = row["errors"]["total"], row["errors"].get("clustering", {})
        errors = [*(total[metric] for metric in ("rel_mse", "mse", "energy")), clustering.get("mse")]
        kept = row["skips"]["kept_clusters"] / max(row["counts"]["vpl_clusters"], 1)
        times = [number(indirect_ms(row)), spread_text(row["frame_ms"])]
        lines.append([row["scene"], *times, *map(number, errors), f"{kept:,.0f} of {row['counts']['sp_clusters']:,}"])
    return table([*head, "SP clusters kept"], lines)


def stages_table(rows: list[Row]) -> str:
    """Median times of the stages of the default settings, from nothing and in motion."""
    own = default_rows(rows)
    stages = list(dict.fromkeys(name for row in own for name in row["stages"]))
    lines = [
        [
            row["scene"],
            *(_stage_text(row, stage) for stage in stages),
            number(sum(times["median"] for times in row.get("light_ms", {}).values())),
        ]
        for row in own
    ]
    return table(["scene", *(f"{stage} [ms]" for stage in stages), "VPLs, once [ms]"], lines)


def _stage_text(row: Row, stage: str) -> str:
    """A stage's median time, and in brackets that in motion."""
    alone, moving = (number(of["stages"].get(stage, {}).get("median")) for of in (row, row.get("motion", row)))
    return f"{alone} ({moving})" if "motion" in row else alone


def paper_table(rows: list[Row]) -> str:
    """The paper's settings: its own time and clustering error, and those here."""
    points = paper.POINTS["conference"]
    names = scenes_of([row for row in rows if "paper" in row["groups"]])
    lines = []
    for (sps, vpls), point in zip(paper.SETTINGS, points, strict=True):
        own = {row["scene"]: row for row in setting_rows(rows, sps, vpls)}
        cells = [_time_and_mse(own[name]) if name in own else "–" for name in names]
        lines.append([f"{sps:,} × {vpls:,}", f"{number(point.ms)} / {number(point.mse)}", *cells])
    return table(["SP × VPL clusters", "the paper [ms / MSE]", *names], lines)


def _time_and_mse(row: Row) -> str:
    mse = row["errors"].get("clustering", {}).get("mse")
    return f"{number(row['frame_ms']['median'])} / {number(mse)}"


def decompose_table(rows: list[Row]) -> str:
    """The parts of relMSE."""
    parts = list(rows[0]["rel_mse"])
    lines = [
        [row["scene"], f"{row['settings']['vpls']:,}", *(number(row["rel_mse"][part]) for part in parts)]
        for row in rows
    ]
    return table(["scene", "VPLs", *(part.replace("_", " ") for part in parts)], lines)


def temporal_table(rows: list[Row]) -> str:
    """Flicker and what it is made of."""
    keys = ("flicker", "change", "reference_change", "error_change")
    lines = [
        [row["scene"], method_text(row), *(number(row[key]) for key in keys), number(row["clustering_rel_mse"]["mean"])]
        for row in rows
    ]
    return table(["scene", "settings", *(key.replace("_", " ") for key in keys), "clustering relMSE"], lines)


def skips_table(rows: list[Row]) -> str:
    """What the other state of each switch changes."""
    head = ["switch", "scene", "usual [ms]", "flipped [ms]", "gain [%]", "relMSE", "flipped", "FLIP between them"]
    lines = []
    for row in sorted(rows, key=lambda row: row["switch"]):
        usual, flipped = row["usual"], row["flipped"]
        gain = 100.0 * (1.0 - usual["frame_ms"]["median"] / flipped["frame_ms"]["median"])
        errors = [number(state["errors"]["rel_mse"]) for state in (usual, flipped)]
        times = [spread_text(state["frame_ms"]) for state in (usual, flipped)]
        lines.append([row["switch"], row["scene"], *times, f"{gain:.1f}", *errors, number(row["change"]["flip"])])
    return table(head, lines)


def peers_table(rows: list[Row]) -> str:
    """When the path tracers reach the error of each other row; a dash is outside of what was measured."""
    tracers = [method for method in ("path", "mitsuba") if any(row["method"] == method for row in rows)]
    lines = []
    for scene in scenes_of(rows):
        own = [row for row in rows if row["scene"] == scene]
        curves = {
            name: points_of([row for row in own if row["method"] == name], "total", "rel_mse") for name in tracers
        }
        for row in own:
            error = row["errors"]["total"]["rel_mse"]
            equal = [time_to_equal_error(points, error) if points and error else None for points in curves.values()]
            lines.append([scene, method_text(row), spread_text(row["frame_ms"]), number(error), *map(number, equal)])
    return table(["scene", "method", "frame [ms]", "relMSE", *(f"{name} takes [ms]" for name in tracers)], lines)


def still_table(rows: list[Row]) -> str:
    """Error after one frame, after a second, and of all frames."""
    lines = []
    for row in rows:
        points = row["points"]
        for point in (points[0], within(row, STILL_SECONDS) or points[0], points[-1]):
            errors = point["errors"]
            values = [number(errors[name]) for name in ("rel_mse", "mse", "flip", "energy")]
            values.insert(1, number(point["rel_mse_beyond_noise"]))
            lines.append([row["scene"], str(point["frames"]), f"{point['seconds']:.2f}", *values])
    head = ["scene", "frames", "seconds", "relMSE", "beyond the reference's noise", "MSE", "HDR-FLIP", "energy"]
    return table(head, lines)


def targets_table(rows: list[Row]) -> str:
    """How a walk held its target: over the target, and the shares of it that were within 10 %, above and below."""
    head = [
        "scene",
        "target",
        "over target",
        "mean",
        "within 10 %",
        "above",
        "below at the fewest counts",
        "tries",
        "stages [ms]",
        "with the host [ms]",
        "measured at",
        "changes",
        "pairs",
        "passes",
    ]
    lines = []
    for row in rows:
        (kind, target), compared = next(iter(row["target"].items())), targeted(row)
        goal, places = f"{target:g} ms" if kind == "ms" else f"MSE {target:g}", f"{len(compared)} of {row['frames']}"
        held, within = row["held"], f"{100.0 * row['held']['within']:.0f} %"
        above = f"{100.0 * sum(value > (1.0 + WITHIN) * target for value in compared) / len(compared):.0f} %"
        below = f"{100.0 * row['below_at_fewest']:.0f} %" if "below_at_fewest" in row else "–"
        tries = f"{row['tries']:.2f}" if "tries" in row else "1"
        spreads, counts = [spread_text(held), number(held["mean"])], [str(row["changes"]), spread_text(row["pairs"])]
        times = [spread_text(spread(row["path_ms"])), spread_text(row["wall_ms"]) if "wall_ms" in row else "–"]
        passes = spread_text(row["passes"]) if row.get("passes", {}).get("p95", 1.0) > 1.0 else "1"
        lines.append([row["scene"], goal, *spreads, within, above, below, tries, *times, places, *counts, passes])
    return table(head, lines)


def growth_table(rows: list[Row]) -> str:
    """Times at both ends, and the powers between them."""
    lines = []
    for axis, label in GROWTH_AXES.items():
        for name, points in growth_series([row for row in rows if row["axis"] == axis]).items():
            if len(points) > 1:
                (low, first), (high, last) = points[0], points[-1]
                whole, upper = slopes(points)
                ends = [f"{low:,.0f}", number(first), f"{high:,.0f}", number(last)]
                lines.append([label, name, *ends, f"{whole:.2f}", f"{upper:.2f}"])
    return table(["over", "stage", "from", "ms", "to", "ms", "slope", "slope, upper half"], lines)


def walk_table(rows: list[Row]) -> str:
    """Frames a second."""
    lines = [
        [row["scene"], "×".join(map(str, row["size"])), f"{row['frames_a_second']:.1f}", spread_text(row["wall_ms"])]
        for row in rows
    ]
    return table(["scene", "size", "frames a second", "frame [ms]"], lines)
