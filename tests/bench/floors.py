"""Measured times of the stages beside their floors: what a frame cannot do without, over rates measured here."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import cache, partial
from typing import Any
from unittest.mock import patch

import warp as wp

from gpu.core.stages import Stages
from gpu.renderer import Renderer
from gpu.settings import RenderSettings
from tests.bench.floor_model import floors
from tests.bench.rates import Rates, byte_rate, fma_rate, launch_rate, ray_rates
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import Measured, measure_frames


@contextmanager
def launches_counted() -> Iterator[Counter[str]]:
    """Counts each stage's kernel launches, as long as this is open; a graph that is replayed launches none."""
    counts: Counter[str] = Counter()
    running = [""]
    launch, run = wp.launch, Stages.run

    def counted(*arguments: Any, **options: Any) -> Any:
        counts[running[0]] += 1
        return launch(*arguments, **options)

    def named(stages: Stages, name: str, work: Callable[[], None], **options: Any) -> None:
        running[0] = name
        run(stages, name, work, **options)
        running[0] = ""

    with patch.object(wp, "launch", counted), patch.object(Stages, "run", named):
        yield counts


def amounts(measured: Measured, settings: RenderSettings) -> dict[str, float]:
    """The counts of a frame that floors are made of."""
    counts, skips = measured.stats.counts, measured.stats.skips
    sps = counts.get("shaded", counts["pixels"])
    away = sum(count for name, count in skips.items() if "facing" in name)
    facing = 1.0 - away / max(1, counts["sp_clusters"] * counts["vpl_clusters"])
    near = sps * counts["vpl_clusters"] - skips["far_field_sums"]
    return {**counts, "sps": sps, "facing": facing, "near_pairs": near, "fuzziness": settings.fuzziness}


def run(suite: Suite) -> None:
    """The part of the command line."""
    settings = suite.settings()

    @cache
    def machine() -> tuple[float, float, float]:
        subject = suite.subject(suite.scene_names()[0])
        device = subject.device_scene.device
        return byte_rate(device), fma_rate(device), launch_rate(device)

    def measure_row(name: str) -> Row:
        subject = suite.subject(name)
        renderer = Renderer(subject.device_scene, subject.size, settings)
        with launches_counted() as launches:
            renderer.render(subject.camera)
        measured = measure_frames(renderer, subject.camera, suite.frames)
        counts = amounts(measured, settings)
        rates = asdict(Rates(*machine(), *ray_rates(subject.device_scene, subject.size, settings)))
        # A CPU's launches are threads' slices, side by side.
        stages = floors(measured.stages, counts, rates, launches if suite.is_cuda else {})
        return {
            "scene": name,
            "size": list(subject.size),
            "settings": settings.model_dump(mode="json"),
            "frames": measured.frames,
            "counts": counts,
            "rates": rates,
            "stages": {stage: {**times, **stages.get(stage, {})} for stage, times in measured.stages.items()},
        }

    suite.run("floors", [Task(suite.label(name), partial(measure_row, name)) for name in suite.scene_names()])
