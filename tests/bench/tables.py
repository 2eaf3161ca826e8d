"""The page of tables: every row in figures, under the plots that show it."""

from collections import Counter
from collections.abc import Callable, Iterable

from tests.bench.figures import time_to_equal_error
from tests.bench.rows import GROWTH_AXES, growth_series, method_text, points_of, scenes_of, slopes
from tests.bench.store import Row

TITLES = {
    "sweep": "Indirect light: time and error",
    "decompose": "Bias and noise",
    "temporal": "Flicker",
    "skips": "Switches",
    "still": "A view that rests: error over time",
    "peers": "All light: time to equal error",
    "growth": "Growth",
    "pictures": "Pictures",
    "walk": "Frames a second",
}


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


def sweep_table(rows: list[Row]) -> str:
    """Times, errors against both references, and stages."""
    stages = list(dict.fromkeys(name for row in rows for name in row.get("stages", ())))
    head = ["scene", "settings", "frame [ms]", "relMSE", "MSE", "FLIP", "energy", "clustering MSE", "relMSE", "FLIP"]
    lines = []
    for row in sorted(rows, key=lambda row: row["scene"]):
        total, clustering = row["errors"]["total"], row["errors"].get("clustering", {})
        lines.append(
            [
                row["scene"],
                method_text(row),
                spread_text(row["frame_ms"]),
                *(number(total[metric]) for metric in ("rel_mse", "mse", "flip", "energy")),
                *(number(clustering.get(metric)) for metric in ("mse", "rel_mse", "flip")),
                str(sum(errors["nonfinite"] for errors in row["errors"].values())),
                *(number(row.get("stages", {}).get(stage, {}).get("median")) for stage in stages),
            ]
        )
    return table([*head, "non-finite", *(f"{stage} [ms]" for stage in stages)], lines)


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
        second = [point for point in points if point["seconds"] <= 1.0] or points[:1]
        for point in (points[0], second[-1], points[-1]):
            errors = point["errors"]
            values = [number(errors[name]) for name in ("rel_mse", "mse", "flip", "energy")]
            lines.append([row["scene"], str(point["frames"]), f"{point['seconds']:.2f}", *values])
    return table(["scene", "frames", "seconds", "relMSE", "MSE", "FLIP", "energy"], lines)


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


TABLES: dict[str, Callable[[list[Row]], str]] = {
    "sweep": sweep_table,
    "decompose": decompose_table,
    "temporal": temporal_table,
    "skips": skips_table,
    "still": still_table,
    "peers": peers_table,
    "growth": growth_table,
    "walk": walk_table,
}


def report(rows: dict[str, list[Row]], plots: dict[str, list[tuple[str, str]]]) -> str:
    """The page: what it was measured on, then each part's plots and table. plots: (name, caption) by part."""
    surroundings = Counter(tuple(row["environment"].items()) for part in rows.values() for row in part)
    lines = ["# Benchmark", "", "Times are medians, with the 5th to 95th percentile in brackets. Measured on:", ""]
    for items, count in surroundings.most_common():
        lines.append(f"- {count} rows: {', '.join(f'{name} {value}' for name, value in items)}")
    for part, title in TITLES.items():
        if not rows[part]:
            continue
        lines += ["", f"## {title}", ""]
        lines += [f"![{caption}](plots/{name}.png)\n" for name, caption in plots.get(part, ())]
        if part in TABLES:
            lines += [TABLES[part](rows[part])]
    return "\n".join(lines) + "\n"
