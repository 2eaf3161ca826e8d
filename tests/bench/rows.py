"""How plots and tables read the rows of results files."""

from typing import Any

from tests.bench.figures import slope
from tests.bench.store import Row

Points = list[tuple[float, float]]
# Of one quantity, by scene.
Values = dict[str, float]

GROWTH_AXES = {"sps": "shading points", "vpls": "VPLs", "triangles": "triangles"}
ONCE = {"tracing virtual point lights": "trace VPLs (once)", "clustering virtual point lights": "cluster VPLs (once)"}
UPLOAD = "upload and build (once)"
# Stages that a frame has whether it has indirect light or not.
COMMON_STAGES = ("gbuffer", "direct", "display")


def scenes_of(rows: list[Row]) -> list[str]:
    """The scenes of `rows` in their order."""
    return list(dict.fromkeys(row["scene"] for row in rows))


def default_rows(rows: list[Row]) -> list[Row]:
    """The sweep's rows of `fuzzy-vpl` with the default counts, one a scene."""
    return [row for row in rows if "default" in row["groups"] and row["settings"]["method"] == "fuzzy-vpl"]


def motion_rows(rows: list[Row]) -> list[Row]:
    """What was measured in motion for those of `rows` that have it, each as a row."""
    return [{"scene": row["scene"], **row["motion"]} for row in rows if "motion" in row]


def setting_rows(rows: list[Row], sp_clusters: int, vpl_clusters: int) -> list[Row]:
    """The sweep's rows of one of the paper's settings, one a scene."""
    wanted = {"sp_clusters": sp_clusters, "vpl_clusters": vpl_clusters}
    return [row for row in rows if "paper" in row["groups"] and wanted.items() <= row["settings"].items()]


def indirect_ms(row: Row) -> float:
    """Median times of the stages of indirect light, added up."""
    return sum(times["median"] for stage, times in row["stages"].items() if stage not in COMMON_STAGES)


def error_values(rows: list[Row], kind: str, metric: str) -> Values:
    """An error by scene, of the rows that have it."""
    return {row["scene"]: row["errors"][kind][metric] for row in rows if kind in row["errors"]}


def within(row: Row, seconds: float) -> Row | None:
    """The last point of a still view that was there after `seconds`."""
    there = [point for point in row["points"] if point["seconds"] <= seconds]
    return there[-1] if there else None


def points_of(rows: list[Row], error: str, metric: str) -> Points:
    """(median time [ms], error) of the rows that have it, from the least work to the most."""

    def work(row: Row) -> tuple[int, ...]:
        return tuple(row["settings"].get(key) or 0 for key in ("samples", "vpls", "sp_clusters", "vpl_clusters"))

    return [
        (row["frame_ms"]["median"], row["errors"][error][metric])
        for row in sorted(rows, key=work)
        if row["errors"].get(error, {}).get(metric)
    ]


def counts_text(settings: dict[str, Any]) -> str:
    """What was clustered into how many."""
    clusters = {
        "both": f"{settings['sp_clusters']:,} SP × {settings['vpl_clusters']:,} VPL clusters",
        "sps": f"{settings['sp_clusters']:,} SP clusters",
        "vpls": f"{settings['vpl_clusters']:,} VPL clusters",
    }
    return f"{clusters[settings['clustering']]}, {settings['vpls']:,} VPLs"


def blend_text(settings: dict[str, Any]) -> str:
    """How clusters are blended where that is not as usual, after a comma."""
    text = "" if settings["fuzziness"] == 6 else f", F = {settings['fuzziness']}"
    return text + ("" if settings["weighting"] == "distance" else f", {settings['weighting']}")


def method_text(row: Row) -> str:
    """What a row of the sweep or of peers was rendered with."""
    settings = row["settings"]
    if row.get("method") == "mitsuba" or settings["method"] == "path":
        return f"{row.get('method', 'path')}, {settings['samples']:,} samples"
    if settings["method"] == "exact-vpl":
        return f"exact-vpl, {settings['vpls']:,} VPLs"
    return counts_text(settings) + blend_text(settings)


def growth_series(rows: list[Row]) -> dict[str, Points]:
    """(x, median ms) by stage, the whole frame first, what is done once last; each by x."""
    series: dict[str, Points] = {}
    for row in sorted(rows, key=lambda row: row["x"]):
        times = {"frame": row["frame_ms"]["median"]}
        times |= {name: spread["median"] for name, spread in row["stages"].items()}
        times |= {ONCE[name]: spread["median"] for name, spread in row.get("light_ms", {}).items() if name in ONCE}
        times |= {UPLOAD: row["upload_ms"]} if "upload_ms" in row else {}
        for name, time in times.items():
            if time > 0.0:
                series.setdefault(name, []).append((row["x"], time))
    return series


def slopes(points: Points) -> tuple[float, float]:
    """The power of the whole range and that of its upper half."""
    x, y = zip(*points, strict=True)
    half = len(x) // 2
    return slope(x, y), slope(x[half:], y[half:])


def targeted(row: Row) -> list[float]:
    """What frames of a walk for a target took or had; older rows tell only what their stages took."""
    values: list[float] = row.get("errors") or row.get("path_wall_ms") or row["path_ms"]
    return values


def over_target(row: Row) -> tuple[list[int], list[float]]:
    """The frames of a walk for a target that were measured, and what they had over what was wanted."""
    values, (target,) = targeted(row), row["target"].values()
    every = row["frames"] // len(values)
    return [every * (1 + number) for number in range(len(values))], [value / target for value in values]
