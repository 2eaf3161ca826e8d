"""Plots of results: ages and frames against viewers, where the time goes, and memory against time. Needs matplotlib."""

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from gpu.errors import UserError
from tests.load.figures import PARTS, Row
from tests.load.results import load


def draw(folder: Path) -> list[Path]:
    """Plot what a folder of results holds, as PNG files beside it; UserError when there is nothing to plot."""
    made = []
    for name, plot in (("ramp", plot_ramp), ("soak", plot_soak)):
        results = load(folder, name)
        if results is not None:
            file = folder / f"{name}.png"
            figure = plot(results)
            figure.savefig(file, dpi=120)
            plt.close(figure)
            made.append(file)
    if not made:
        raise UserError(f"{folder}: there is no ramp.json or soak.json to plot")
    return made


def plot_ramp(results: dict[str, Any]) -> Figure:
    """Ages with the service level, frames a second, and the parts of the age, each against the number of viewers."""
    rows: list[Row] = [row for row in results["rows"] if row["age"]]
    viewers = [row["viewers"] for row in rows]
    figure, (ages, rates, shares) = plt.subplots(3, 1, figsize=(8, 11), sharex=True, constrained_layout=True)
    for name in ("p50", "p95", "p99"):
        ages.plot(viewers, [row["age"][name] for row in rows], marker="o", label=name)
    ages.axhline(results["level"]["age"], color="grey", linestyle=":", label="service level of p95")
    ages.set(ylabel="pose to bytes [ms]", ylim=(0, None), title=f"{results['environment']['device']}: {_what(results)}")
    for row in rows:
        point = (row["viewers"], row["age"]["p95"])
        ages.annotate(row["bottleneck"], point, xytext=(0, 8), textcoords="offset points", fontsize=7, ha="center")
    rates.plot(viewers, [row["fps"]["mean"] for row in rows], marker="o", label="mean")
    rates.plot(viewers, [row["fps"]["least"] for row in rows], marker="o", label="least of all viewers")
    rates.axhline(results["level"]["fps"], color="grey", linestyle=":", label="service level")
    rates.set(ylabel="frames a second and viewer", ylim=(0, None))
    shares.stackplot(viewers, *([row["parts_ms"][part] for row in rows] for part in PARTS), labels=PARTS)
    shares.set(ylabel="mean parts of the way [ms]", xlabel="viewers", xscale="log", xticks=viewers, xticklabels=viewers)
    shares.set_xlim(viewers[0] / 1.7, viewers[-1] * 1.7)
    shares.minorticks_off()
    for axes in (ages, rates, shares):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    return figure


def plot_soak(results: dict[str, Any]) -> Figure:
    """Memory by process, with its slope after the warm-up, and viewers, against time."""
    row = results["row"]
    names = list(row["growth"])
    figure, all_axes = plt.subplots(len(names) + 1, 1, figsize=(9, 10), sharex=True, constrained_layout=True)
    for axes, name in zip(all_axes, names, strict=False):
        having = [sample for sample in row["samples"] if name in sample]
        axes.plot([sample["seconds"] / 60 for sample in having], [sample[name] for sample in having])
        line = row["growth"][name]
        axes.set(ylabel=f"{name[:-3]} [MB]", title=f"{line['mb_a_minute']:+.3f} ± {line['error']:.3f} MB a minute")
    times = [sample["seconds"] / 60 for sample in row["samples"]]
    all_axes[-1].step(times, [sample["viewers"] for sample in row["samples"]], where="post")
    all_axes[-1].set(ylabel="viewers", xlabel="minutes")
    figure.suptitle(f"{results['environment']['device']}: {row['visits']} visits, {row['frames']} frames")
    for axes in all_axes:
        axes.grid(alpha=0.3)
    return figure


def _what(results: dict[str, Any]) -> str:
    options = results["options"]
    scene = f", {options['scene']}" if "scene" in options else ""
    return f"{options['size'][0]}×{options['size'][1]}, poses at {options['hz']:g} Hz{scene}"
