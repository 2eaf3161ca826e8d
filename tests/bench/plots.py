"""Plots for the page of results, made of the other parts' JSON files alone. SceneFeatures matplotlib: the extra
`bench`.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

from gpu.errors import UserError
from tests.bench.store import Row
from tests.bench.suite import Suite

# The names of the files that a plot was saved as.
Plots = Iterator[str]


def run(suite: Suite) -> None:
    """The part of the command line: images in the folder of the page, in place of all that were there."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise UserError("plots need matplotlib: pip install 'lumenwalk[bench]'") from error
    from tests.bench import floor_plots, growth_plots, quality_plots, setting_plots, sweep_plots
    from tests.bench.charts import use_style

    makers: dict[str, tuple[Callable[[list[Row], Path], Plots], ...]] = {
        "sweep": (
            sweep_plots.error_over_time,
            sweep_plots.stage_stacks,
            sweep_plots.grids,
            setting_plots.fuzziness,
            setting_plots.vpls,
        ),
        "floors": (floor_plots.floors,),
        "decompose": (quality_plots.error_parts,),
        "temporal": (quality_plots.flicker_bars,),
        "targets": (quality_plots.targets,),
        "still": (quality_plots.rest,),
        "peers": (sweep_plots.peers_over_time,),
        "growth": (growth_plots.growth,),
        "pictures": (quality_plots.error_maps,),
    }
    use_style()
    rows, folder = suite.measured(), suite.images_folder
    for old in (*folder.glob("*.png"), *folder.glob("*.jpg")):
        old.unlink()
    made = [
        name for part, own in makers.items() if rows.get(part) for maker in own for name in maker(rows[part], folder)
    ]
    print(f"plots: {len(made)} in {folder}")
