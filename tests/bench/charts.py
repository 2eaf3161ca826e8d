"""The look of the plots: one colour a method, stage or scene, log axes, and saving. Imports matplotlib."""

from collections.abc import Iterable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from tests.bench.store import Row

# Okabe and Ito's colours, told apart by all kinds of sight, and greys for what is everywhere.
BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY, YELLOW, INK, GREY = (
    "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#d8c300", "#22262b", "#9aa0a6",
)  # fmt: skip
STAGES = {
    "gbuffer": GREY,
    "direct": YELLOW,
    "history": "#7a6fb0",
    "cluster": BLUE,
    "visibility": VERMILION,
    "shade": ORANGE,
    "correct": GREEN,
    "refine": PURPLE,
    "bright": "#b58900",
    "near": "#7f5f3f",
    "interpolate": SKY,
    "keep": "#5f7f5f",
    "gather": "#8f3b1b",
    "paths": INK,
    "display": "#c9cdd2",
}
SCENES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, INK, SKY, "#7f5f3f")
OTHER_STAGES = ("#c04f7d", "#4f6f8f", "#a88f3f")
# Two colours from dark to light for what has an order, such as error.
SEQUENCE = "magma"
FEW_DECADES = 1.8
PLOT_COLOURS = 128
# A photo has the first of these qualities that makes it small enough for a repository.
PHOTO_QUALITIES, MOST_PHOTO_BYTES = (85, 75, 65, 50), 280_000


def use_style() -> None:
    """Make figures quiet: light grid, no frame above or to the right."""
    mpl.use("Agg")
    mpl.rcParams.update(
        {
            "axes.axisbelow": True,
            "axes.edgecolor": GREY,
            "axes.grid": True,
            "axes.labelcolor": INK,
            "axes.spines.right": False,
            "axes.spines.top": False,
            "axes.titlelocation": "left",
            "axes.titlesize": 11,
            "axes.titleweight": "bold",
            "figure.constrained_layout.use": True,
            "figure.dpi": 130,
            "font.family": "sans-serif",
            "font.size": 9.5,
            "grid.color": "#e6e8eb",
            "grid.linewidth": 0.7,
            "legend.fontsize": 8.5,
            "legend.frameon": False,
            "lines.linewidth": 1.6,
            "lines.markersize": 4.5,
            "text.color": INK,
            "xtick.color": INK,
            "ytick.color": INK,
        }
    )


def panels(rows: int, columns: int, width: float = 5.4, height: float = 4.0) -> tuple[Figure, list[Axes]]:
    """A figure with rows × columns axes, in reading order."""
    figure, axes = plt.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False)
    return figure, list(axes.ravel())


def titled_panels(titles: list[str], most: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure with axes for each of `titles`, at most `most` side by side."""
    columns = min(most, len(titles))
    figure, axes = panels(-(-len(titles) // columns), columns, width, height)
    for panel in axes[len(titles) :]:
        panel.remove()
    for panel, title in zip(axes, titles, strict=False):
        panel.set_title(title)
    return figure, axes[: len(titles)]


def log_log(axes: Axes, x_label: str, y_label: str) -> None:
    """Both axes logarithmic once the data are drawn: numbers at the decades, at 2 and 5 too where there are few."""
    axes.set(xscale="log", yscale="log", xlabel=x_label, ylabel=y_label)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        few = np.log10(high / low) < FEW_DECADES
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value)))
        axis.set_minor_locator(LogLocator(subs=tuple(map(float, range(1, 10))), numticks=20))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="minor", linewidth=0.35)


def tick_text(value: float) -> str:
    """A number that people read: plain where it is short, else in powers of ten."""
    if 0.01 <= value < 10_000.0:
        return f"{value:g}"
    exponent = int(np.floor(np.log10(value) + 1e-9))
    factor = round(value / 10.0**exponent)
    return f"$10^{{{exponent}}}$" if factor == 1 else f"${factor} \\cdot 10^{{{exponent}}}$"


def legend_below(figure: Figure, axes: Sequence[Axes], columns: int) -> None:
    """One legend for all `axes`, each label once."""
    entries: dict[str, Any] = {}
    for panel in axes:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns)


def scene_colours(rows: Iterable[Row]) -> dict[str, str]:
    """A colour for each scene, by its name's place among all: the same in every panel that `rows` are spread over."""
    return dict(zip(sorted({row["scene"] for row in rows}), SCENES, strict=False))


def stage_colour(stage: str, stages: Sequence[str]) -> str:
    """The colour of a stage, always the same; of unknown ones by their place among `stages`."""
    unknown = [name for name in stages if name not in STAGES]
    return STAGES[stage] if stage in STAGES else OTHER_STAGES[unknown.index(stage) % len(OTHER_STAGES)]


def save(figure: Figure, folder: Path, name: str, *, photo: bool = False) -> str:
    """Write NAME.png, of few colours, or NAME.jpg of a `photo`; returns the file's name. Both are kept small."""
    folder.mkdir(parents=True, exist_ok=True)
    file = BytesIO()
    figure.savefig(file, format="png")
    plt.close(figure)
    image = Image.open(file).convert("RGB")
    if photo:
        path = folder / f"{name}.jpg"
        for quality in PHOTO_QUALITIES:
            image.save(path, quality=quality, optimize=True)
            if path.stat().st_size < MOST_PHOTO_BYTES:
                break
        return path.name
    image.quantize(PLOT_COLOURS, dither=Image.Dither.NONE).save(folder / f"{name}.png", optimize=True)
    return f"{name}.png"
