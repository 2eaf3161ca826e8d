"""Plots of the sweep over one setting: fuzziness with both weightings, and the number of VPLs."""

from pathlib import Path

from tests.bench.charts import legend_below, log_log, panels, save, scene_colours
from tests.bench.plots import Plots
from tests.bench.store import Row

STYLES = {"distance": "o-", "average": "s--"}


def fuzziness(rows: list[Row], folder: Path) -> Plots:
    """One figure: clustering error and time over F, a line for each scene and weighting."""
    own = [row for row in rows if "fuzziness" in row["groups"] and "clustering" in row["errors"]]
    if len({row["settings"]["fuzziness"] for row in own}) < 2:
        return
    figure, axes = panels(1, 2)
    for scene, colour in scene_colours(own).items():
        for weighting, style in STYLES.items():
            line = sorted(
                (row["settings"]["fuzziness"], row["errors"]["clustering"]["rel_mse"], row["frame_ms"]["median"])
                for row in own
                if row["scene"] == scene and row["settings"]["weighting"] == weighting
            )
            if line:
                f, error, time = zip(*line, strict=True)
                axes[0].plot(f, error, style, color=colour, label=f"{scene}, {weighting}")
                axes[1].plot(f, time, style, color=colour)
    axes[0].set(title="Clustering error", xlabel="F, clusters of a shading point", ylabel="relMSE", yscale="log")
    axes[1].set(title="Time", xlabel="F, clusters of a shading point", ylabel="frame time [ms]", ylim=(0.0, None))
    legend_below(figure, axes[:1], 4)
    figure.suptitle("Fuzziness and weighting", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "fuzziness")


def vpls(rows: list[Row], folder: Path) -> Plots:
    """One figure: errors and time over the number of VPLs with the same clusters, a line a scene."""
    own = [row for row in rows if "vpls" in row["groups"]]
    if len({row["settings"]["vpls"] for row in own}) < 2:
        return
    figure, axes = panels(1, 3, 4.6)
    for scene, colour in scene_colours(own).items():
        line = sorted((row for row in own if row["scene"] == scene), key=lambda row: row["settings"]["vpls"])
        for panel, kind in zip(axes, ("total", "clustering"), strict=False):
            points = [
                (row["settings"]["vpls"], row["errors"][kind]["rel_mse"]) for row in line if kind in row["errors"]
            ]
            panel.plot(*zip(*points, strict=True), "o-", color=colour, label=scene)
        times = [(row["settings"]["vpls"], row["frame_ms"]["median"]) for row in line]
        axes[2].plot(*zip(*times, strict=True), "o-", color=colour)
    for panel, title in zip(axes, ("Total error", "Clustering error", "Time"), strict=True):
        log_log(panel, "VPLs", "frame time [ms]" if title == "Time" else "relMSE")
        panel.set_title(title)
    legend_below(figure, axes[:1], 6)
    figure.suptitle("Number of VPLs", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "vpls")
