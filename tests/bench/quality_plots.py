"""Plots of what is wrong with pictures: error maps, the error's parts, and flicker."""

from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch

from tests.bench.charts import (
    BLUE,
    GREEN,
    ORANGE,
    SEQUENCE,
    VERMILION,
    legend_below,
    log_log,
    panels,
    save,
    scene_colours,
    titled_panels,
)
from tests.bench.goals import STILL_ERROR, STILL_SECONDS, WITHIN
from tests.bench.pictures import LEAST_DECADE, MOST_DECADE, decoded
from tests.bench.plots import Plots
from tests.bench.rows import blend_text, counts_text, over_target, scenes_of
from tests.bench.store import Row

MAPS = {"total_error": "against path tracing", "clustering_error": "against exact-vpl"}


def error_maps(rows: list[Row], folder: Path) -> Plots:
    """One figure a scene: a row of render, reference and maps of relative squared error for each setting."""
    norm = Normalize(LEAST_DECADE, MOST_DECADE)
    for scene in scenes_of(rows):
        own = [row for row in rows if row["scene"] == scene]
        width, height = own[0]["size"]
        side = 3.2 * min(1.0, width / height) ** 0.5
        figure, axes = panels(len(own), 4, side, side * height / width + 0.3)
        for number, row in enumerate(own):
            line = axes[4 * number : 4 * number + 4]
            line[0].imshow(decoded(row["render"]))
            line[0].set_title("VPL clusters,\n".join(counts_text(row["settings"]).split("VPL clusters, ")), fontsize=8)
            line[1].imshow(decoded(row["reference"]))
            line[1].set_title("path tracing", fontsize=8)
            for panel, (key, what) in zip(line[2:], MAPS.items(), strict=True):
                if key in row:
                    decades = decoded(row[key]) / 255.0 * (MOST_DECADE - LEAST_DECADE) + LEAST_DECADE
                    panel.imshow(decades, cmap=SEQUENCE, norm=norm)
                    panel.set_title(f"error {what}", fontsize=8)
            for panel in line:
                panel.set_axis_off()
        ticks = np.arange(LEAST_DECADE, MOST_DECADE + 1.0)
        bar = figure.colorbar(
            ScalarMappable(norm, SEQUENCE), ax=axes, location="bottom", shrink=0.4, aspect=60, ticks=ticks, pad=0.02
        )
        bar.ax.set_xticklabels([f"$10^{{{int(tick)}}}$" for tick in ticks])
        bar.set_label("relative squared error")
        yield save(figure, folder, f"pictures-{scene}", photo=True)


def error_parts(rows: list[Row], folder: Path) -> Plots:
    """One figure: bias and noise of VPLs, of clustering, and of both together, for each scene and number of VPLs."""
    counts = sorted({row["settings"]["vpls"] for row in rows})
    figure, axes = panels(1, len(counts), 6.0, 4.0)
    parts = {"vpl": ("VPLs", BLUE), "clustering": ("clustering", ORANGE), "total": ("both", VERMILION)}
    for panel, vpls in zip(axes, counts, strict=True):
        own = [row for row in rows if row["settings"]["vpls"] == vpls]
        for offset, (part, (_, colour)) in enumerate(parts.items()):
            place = np.arange(len(own)) + 0.26 * (offset - 1)
            bias, noise = (
                np.array([max(row["rel_mse"][f"{part}_{kind}"], 0.0) for row in own]) for kind in ("bias", "noise")
            )
            panel.bar(place, bias, 0.24, color=colour)
            panel.bar(place, noise, 0.24, bottom=bias, color=colour, alpha=0.4)
        panel.set_xticks(range(len(own)), [row["scene"] for row in own], rotation=20, ha="right")
        panel.set(title=f"{vpls:,} VPLs", ylabel="relMSE")
        panel.grid(False, axis="x")
    handles = [Patch(color=colour, label=label) for label, colour in parts.values()]
    handles += [Patch(color="#555555", label="bias"), Patch(color="#555555", alpha=0.4, label="noise")]
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    figure.suptitle("Error of indirect light told apart", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "error-parts")


def flicker_bars(rows: list[Row], folder: Path) -> Plots:
    """One figure: change between frames of a walk for each scene and choice of settings."""
    names = scenes_of(rows)
    figure, axes = titled_panels(names, 3, 5.6, 3.4)
    for panel, scene in zip(axes, names, strict=True):
        own = [row for row in rows if row["scene"] == scene][::-1]
        place = np.arange(len(own))
        panel.barh(place + 0.2, [100.0 * row["change"] for row in own], 0.38, color=BLUE, label="change")
        panel.barh(
            place - 0.2, [100.0 * row["error_change"] for row in own], 0.38, color=ORANGE, label="change of error"
        )
        own_change = 100.0 * own[0]["reference_change"]
        panel.axvline(own_change, color=GREEN, lw=1.6, label="change of exact-vpl")
        panel.set_yticks(place, [_walk_name(row) for row in own])
        panel.set_xlabel("of mean radiance, between frames [%]")
        panel.grid(False, axis="y")
    legend_below(figure, axes[:1], 3)
    figure.suptitle("Flicker along a walk", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "flicker")


def _walk_name(row: Row) -> str:
    settings = row["settings"]
    return f"{settings['sp_clusters']:,} × {settings['vpl_clusters']:,}{blend_text(settings)}"


def rest(rows: list[Row], folder: Path) -> Plots:
    """One figure: relMSE of the whole picture over the time that the view has rested, two curves a scene."""
    figure, axes = panels(1, 1, 6.8, 4.4)
    colours = scene_colours(rows)
    for row in rows:
        colour = colours[row["scene"]]
        points = [(point["seconds"], point["errors"]["rel_mse"]) for point in row["points"]]
        beyond = [(point["seconds"], point["rel_mse_beyond_noise"]) for point in row["points"]]
        axes[0].plot(*zip(*beyond, strict=True), "o-", color=colour, label=row["scene"])
        axes[0].plot(*zip(*points, strict=True), ":", color=colour, lw=1.0)
    log_log(axes[0], "seconds of rest", "relMSE")
    left, low = axes[0].get_xlim()[0], axes[0].get_ylim()[0]
    axes[0].fill_between([left, STILL_SECONDS], low, STILL_ERROR, color=GREEN, alpha=0.09, lw=0, label="the goal")
    axes[0].set(xlim=(left, None), ylim=(low, None))
    legend_below(figure, axes, 4)
    figure.suptitle("A view that rests, against path tracing over the pixels", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "rest")


def targets(rows: list[Row], folder: Path) -> Plots:
    """One figure: a panel for each share of the default's time and of the errors that is wanted, a curve a scene."""
    kinds = {"ms": "wanted: {:g} times the default's time", "error": "wanted: {:g} of the way from least error to most"}
    own = {
        text.format(share): [row for row in rows if kind in row["target"] and row["share"] == share]
        for kind, text in kinds.items()
        for share in sorted({row["share"] for row in rows if kind in row["target"]})
    }
    colours = scene_colours(rows)
    figure, axes = titled_panels(list(own), 2, 5.4, 3.6)
    for panel, walks in zip(axes, own.values(), strict=True):
        for row in walks:
            frames, over = over_target(row)
            dots = "." if len(frames) < row["frames"] else ""
            panel.plot(frames, over, marker=dots, linewidth=1.0, color=colours[row["scene"]], label=row["scene"])
        panel.axhspan(1.0 - WITHIN, 1.0 + WITHIN, color=GREEN, alpha=0.12, linewidth=0.0)
        panel.set(ylim=(0.0, 2.0), xlabel="frame", ylabel="over what is wanted")
    legend_below(figure, axes, 6)
    figure.suptitle("Counts chosen for a target, while the camera sways", x=0.01, ha="left", fontweight="bold")
    yield save(figure, folder, "targets")
