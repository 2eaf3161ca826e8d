"""Plots of growth: each stage's time over shading points, VPLs and triangles, with slopes."""

from pathlib import Path

from tests.bench.charts import INK, OTHER_STAGES, log_log, panels, save, stage_colour
from tests.bench.plots import Plots
from tests.bench.rows import GROWTH_AXES, growth_series, scenes_of, slopes
from tests.bench.store import Row


def growth(rows: list[Row], folder: Path) -> Plots:
    """One figure: a panel for each of the three."""
    figure, axes = panels(1, 3, 4.9, 5.2)
    for panel, (axis, label) in zip(axes, GROWTH_AXES.items(), strict=True):
        own = [row for row in rows if row["axis"] == axis]
        series = growth_series(own)
        stages = [name for name in series if name != "frame" and "once" not in name]
        once = [name for name in series if "once" in name]
        for name, points in series.items():
            if len(points) < 2:
                continue
            text = f"{name}: {slopes(points)[0]:.2f}"
            if name == "frame":
                panel.plot(*zip(*points, strict=True), "o-", color=INK, lw=2.4, label=text, zorder=4)
            elif name in once:
                colour = OTHER_STAGES[once.index(name)]
                panel.plot(*zip(*points, strict=True), "s--", color=colour, lw=1.2, ms=3.5, label=text)
            else:
                panel.plot(*zip(*points, strict=True), "o-", color=stage_colour(name, stages), ms=3.5, label=text)
        log_log(panel, label, "median time [ms]")
        scenes = ", ".join(scenes_of(own))
        panel.set_title(f"Over {label} ({scenes})" if scenes else f"Over {label}")
        if own:
            panel.legend(title="slope", loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=2)
    figure.suptitle("Growth of time", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "growth")
