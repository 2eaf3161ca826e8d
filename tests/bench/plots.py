"""Plots and a page of tables, made of the JSON files of the other parts alone. Needs matplotlib: the extra `bench`."""

from collections.abc import Callable, Iterator
from pathlib import Path

from gpu.errors import UserError
from tests.bench.store import Row, read_rows
from tests.bench.suite import Suite

MEASURED = ("sweep", "decompose", "temporal", "skips", "still", "peers", "growth", "pictures", "walk")
Plots = Iterator[tuple[str, str]]


def run(suite: Suite) -> None:
    """The part of the command line: OUT/plots/*.png and *.svg, and OUT/report.md that shows them."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise UserError("plots need matplotlib: pip install 'lumenwalk[bench]'") from error
    from tests.bench import growth_plots, quality_plots, setting_plots, sweep_plots
    from tests.bench.charts import use_style
    from tests.bench.tables import report

    use_style()
    rows = {part: rows_of(suite.out / f"{part}.json", suite.names) for part in MEASURED}
    makers: dict[str, tuple[Callable[[list[Row], Path], Plots], ...]] = {
        "sweep": (
            sweep_plots.error_over_time,
            sweep_plots.stage_stacks,
            sweep_plots.grids,
            setting_plots.fuzziness,
            setting_plots.vpls,
        ),
        "decompose": (quality_plots.error_parts,),
        "temporal": (quality_plots.flicker_bars,),
        "still": (quality_plots.rest,),
        "peers": (sweep_plots.peers_over_time,),
        "growth": (growth_plots.growth,),
        "pictures": (quality_plots.error_maps,),
    }
    folder = suite.out / "plots"
    plots = {
        part: [plot for maker in makers.get(part, ()) for plot in maker(rows[part], folder)]
        for part in MEASURED
        if rows[part]
    }
    page = suite.out / "report.md"
    page.write_text(report(rows, plots))
    print(f"plots: {sum(map(len, plots.values()))} in {folder}, tables in {page}")


def rows_of(path: Path, names: tuple[str, ...]) -> list[Row]:
    """The rows of a file, of the scenes with `names` if any are named; none where there is no file."""
    rows = read_rows(path) if path.exists() else []
    return [row for row in rows if not names or row["scene"] in names]
