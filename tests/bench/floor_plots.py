"""Plot of the floors: each stage's measured time, and what of it the stage cannot do without."""

from pathlib import Path

import numpy as np

from tests.bench.charts import INK, save, stage_colour, titled_panels
from tests.bench.plots import Plots
from tests.bench.store import Row


def floors(rows: list[Row], folder: Path) -> Plots:
    """One figure: a panel a scene with a bar a stage; its solid part is the floor, the number says how many floors."""
    figure, axes = titled_panels([row["scene"] for row in rows], 3, 4.4, 2.6)
    for panel, row in zip(axes, rows, strict=True):
        stages = [stage for stage, times in row["stages"].items() if "floor_ms" in times][::-1]
        measured, floor = (np.array([row["stages"][stage][key] for stage in stages]) for key in ("median", "floor_ms"))
        colours = [stage_colour(stage, stages) for stage in stages]
        panel.barh(stages, measured, color="white", height=0.72)
        panel.barh(stages, measured, color=colours, alpha=0.35, height=0.72)
        panel.barh(stages, floor, color=colours, height=0.72)
        for place, (time, least) in enumerate(zip(measured, floor, strict=True)):
            panel.text(time, place, f" {time:.2g} ms, {time / least:.1f}×", va="center", fontsize=8, color=INK)
        panel.set_xlabel("median time [ms]")
        panel.grid(False, axis="y")
        panel.tick_params(axis="y", length=0)
        panel.margins(x=0.28)
    figure.suptitle("Time of each stage; solid: its floor", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "floors")
