"""Plots of the sweep and of peers: error over time, stacks of stages, and the grid of Fig. 11."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from tests.bench import paper
from tests.bench.charts import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    OTHER_STAGES,
    PURPLE,
    SEQUENCE,
    SKY,
    VERMILION,
    legend_below,
    log_log,
    panels,
    save,
    stage_colour,
    titled_panels,
)
from tests.bench.figures import front
from tests.bench.plots import Plots
from tests.bench.rows import counts_text, default_rows, points_of, scenes_of
from tests.bench.store import Row

# Group of the sweep: its label and colour.
CURVES = {
    "both": ("SPs and VPLs clustered", BLUE),
    "sps": ("SPs clustered", GREEN),
    "vpl-clusters": ("VPLs clustered", ORANGE),
    "vpls": ("more and fewer VPLs", SKY),
    "exact": ("exact-vpl", PURPLE),
    "path": ("path tracing", INK),
}
PAPER_MARKERS = {"both": "*", "sps": "P", "vpls": "X"}
PAPER_CURVES = {"both": "both", "sps": "sps", "vpls": "vpl-clusters"}


def error_over_time(rows: list[Row], folder: Path) -> Plots:
    """One figure a scene: clustering error as the paper has it, and total error, over time, a curve a method."""
    for scene in scenes_of(rows):
        own = [row for row in rows if row["scene"] == scene]
        figure, axes = panels(1, 2, 6.0, 4.6)
        for panel, (error, metric) in zip(axes, (("clustering", "mse"), ("total", "rel_mse")), strict=True):
            _curves(panel, own, error, metric)
            log_log(panel, "frame time [ms]", {"mse": "MSE", "rel_mse": "relMSE"}[metric])
        _paper_points(axes[0], scene)
        axes[0].set_title("Clustering error, against exact-vpl with the same VPLs")
        axes[1].set_title("Total error, against path tracing")
        legend_below(figure, axes, 4)
        figure.suptitle(f"{scene}, indirect light", x=0.01, ha="left", fontweight="bold")
        yield save(figure, folder, f"error-time-{scene}")


def _curves(axes: Axes, rows: list[Row], error: str, metric: str) -> None:
    for group, (label, colour) in CURVES.items():
        points = points_of([row for row in rows if group in row["groups"]], error, metric)
        if len(points) < 2:
            continue
        if group == "both":
            axes.plot(*zip(*points, strict=True), "o", color=colour, alpha=0.25, ms=3.5, mew=0)
            points = front(points)
        axes.plot(*zip(*points, strict=True), "o-", color=colour, label=label)
    marked = {"the paper's settings": (BLUE, [row for row in rows if "paper" in row["groups"]])}
    for row in rows:
        if "default" in row["groups"]:
            colour = (VERMILION, *OTHER_STAGES)[len(marked) - 1]
            marked[f"{row['settings']['method']}, default settings"] = (colour, [row])
    for label, (colour, own) in marked.items():
        points = points_of(own, error, metric)
        if points:
            x, y = zip(*points, strict=True)
            axes.plot(x, y, "D", color="white", mec=colour, mew=1.6, ms=6.5, zorder=5, label=label)


def _paper_points(axes: Axes, scene: str) -> None:
    for point in paper.POINTS.get(paper.paper_scene(scene), ()):
        colour, label = CURVES[PAPER_CURVES[point.clustering]][1], CURVES[PAPER_CURVES[point.clustering]][0]
        marker = PAPER_MARKERS[point.clustering]
        text = f"paper (2022), {label}"
        known = text in axes.get_legend_handles_labels()[1]
        axes.plot(
            point.ms, point.mse, marker, color=colour, ms=10, mec="white", zorder=6, label=None if known else text
        )
        axes.annotate(point.figure, (point.ms, point.mse), (5, 4), textcoords="offset points", fontsize=8, color=INK)


def peers_over_time(rows: list[Row], folder: Path) -> Plots:
    """One figure of all scenes: relMSE of the whole picture over time."""
    names = scenes_of(rows)
    figure, axes = titled_panels(names, 3, 4.6, 3.8)
    looks = {"path": ("path tracing (here)", INK, "o-"), "mitsuba": ("Mitsuba 3", GREEN, "s-")}
    for panel, scene in zip(axes, names, strict=True):
        own = [row for row in rows if row["scene"] == scene]
        for method in dict.fromkeys(row["method"] for row in own):
            label, colour, style = looks.get(method, (method, BLUE, "D"))
            points = points_of([row for row in own if row["method"] == method], "total", "rel_mse")
            if points:
                panel.plot(*zip(*points, strict=True), style, color=colour, label=label)
        log_log(panel, "frame time [ms]", "relMSE")
    legend_below(figure, axes, 4)
    figure.suptitle("All light, against path tracing", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "peers")


def stage_stacks(rows: list[Row], folder: Path) -> Plots:
    """One figure: a panel a scene with the stages' median times of `fuzzy-vpl`, its own and the paper's settings."""
    chosen = [*default_rows(rows), *(row for row in rows if "paper" in row["groups"])]
    names = scenes_of(chosen)
    stages = list(dict.fromkeys(stage for row in chosen for stage in row["stages"]))
    figure, axes = titled_panels(names, 2, 6.4, 2.2)
    for panel, scene in zip(axes, names, strict=True):
        own = [row for row in chosen if row["scene"] == scene]
        own.sort(key=lambda row: row["frame_ms"]["median"], reverse=True)
        labels, left = [counts_text(row["settings"]) for row in own], np.zeros(len(own))
        for stage in stages:
            widths = np.array([row["stages"].get(stage, {"median": 0.0})["median"] for row in own])
            panel.barh(labels, widths, left=left, color=stage_colour(stage, stages), label=stage, height=0.72)
            left += widths
        for place, (row, end) in enumerate(zip(own, left, strict=True)):
            panel.text(end, place, f" {row['frame_ms']['median']:.3g}", va="center", fontsize=8)
        panel.set_xlabel("median time [ms]")
        panel.grid(False, axis="y")
        panel.tick_params(axis="y", length=0)
        panel.margins(x=0.1)
    legend_below(figure, axes[:1], 8)
    yield save(figure, folder, "stages")


def grids(rows: list[Row], folder: Path) -> Plots:
    """One figure a scene: time and clustering error over SP clusters × VPL clusters (Fig. 11)."""
    for scene in scenes_of(rows):
        own = [row for row in rows if row["scene"] == scene and "both" in row["groups"]]
        sps, vpls = (sorted({row["settings"][key] for row in own}) for key in ("sp_clusters", "vpl_clusters"))
        if len(own) < max(4, len(sps) * len(vpls) // 2):
            continue
        times, errors = np.full((2, len(vpls), len(sps)), np.nan)
        for row in own:
            place = vpls.index(row["settings"]["vpl_clusters"]), sps.index(row["settings"]["sp_clusters"])
            times[place] = row["frame_ms"]["median"]
            errors[place] = row["errors"].get("clustering", {}).get("mse") or np.nan
        figure, axes = panels(1, 2, 5.4, 4.4)
        _heat(axes[0], times, sps, vpls, "Frame time [ms]", "{:.3g}")
        _heat(axes[1], errors, sps, vpls, "Clustering MSE", "{:.1e}")
        figure.suptitle(f"{scene}: the grid of Fig. 11", x=0.01, ha="left", fontweight="bold")
        yield save(figure, folder, f"grid-{scene}")


def _heat(axes: Axes, values: np.ndarray, sps: list[int], vpls: list[int], title: str, form: str) -> None:
    """A table of numbers on colours."""
    axes.imshow(values, origin="lower", cmap=SEQUENCE, norm=LogNorm(), aspect="auto")
    middle = np.exp(np.nanmean(np.log(values[values > 0.0]))) if (values > 0.0).any() else 1.0
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = "white" if value < middle else INK
            axes.text(column, row, form.format(value), ha="center", va="center", fontsize=8, color=colour)
    axes.set(title=title, xlabel="SP clusters", ylabel="VPL clusters")
    axes.set_xticks(range(len(sps)), [f"{count:,}" for count in sps])
    axes.set_yticks(range(len(vpls)), [f"{count:,}" for count in vpls])
    axes.grid(False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_facecolor(GREY)
