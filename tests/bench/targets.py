"""How well counts chosen for a wanted frame time or error hold it: a camera that sways to and fro, once a target.

Wanted times are multiples of what the default counts take on the walk, until frames are ready; the most counts that
there are may take less than that. Wanted errors lie between those that the fewest and the most counts have on the walk.
No frame is left out but those before the first picture of a walk. Errors are measured at some frames of the walk:
against `exact-vpl` with the same VPLs, and without near-field light, which the estimate that they are chosen by leaves
out too. Rows keep what every frame took, its counts, and what was expected.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np

from gpu.adaptive.levels import levels_of
from gpu.film.frame import Frame, FrameStats
from gpu.film.metrics import mse
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Floats
from gpu.settings import Component, Method, RenderSettings
from tests.bench.figures import spread
from tests.bench.store import Row, Task
from tests.bench.suite import Suite

# Of what the default counts take in motion; and of the way from the least error to the greatest, in logarithms.
TIMES = (1.25, 2.5)
ERRORS = (0.6, 0.4)
# A sway: so far to either side, so far ahead as a share of the scene's extent, and frames until it is back.
DEGREES, AHEAD, PERIOD = 15.0, 0.04, 96
FRAMES, QUICK_FRAMES, USUAL_FRAMES = 144, 8, 48
# Frames of a walk for an error, of which every so many-th is compared with `exact-vpl`; and those of a running mean.
ERROR_FRAMES, EVERY, RUNNING = 96, 3, 15
# Of these frames, for what is within reach.
REACH_EVERY = 8
# Few enough for `exact-vpl`, enough for a thousand clusters of them.
ERROR_VPLS = 16_000
WITHIN = 0.1


def held(values: Sequence[float], target: float) -> dict[str, float]:
    """The spread of `values` over `target`, their mean, and the share of them that is within 10 % of it."""
    within = np.abs(np.asarray(values) - target) <= WITHIN * target
    ratios = np.asarray(values) / target
    return {**spread(ratios), "mean": float(ratios.mean()), "within": float(within.mean())}


def running_means(values: Sequence[float], count: int) -> list[float]:
    """The means of each `count` values in a row, or of all where they are fewer."""
    count = min(count, len(values))
    return [float(np.mean(values[begin : begin + count])) for begin in range(len(values) - count + 1)]


def path_of(frames: Sequence[FrameStats], wall: Sequence[float], unit: str) -> Row:
    """What the frames of a walk for a target in `unit` took and had: by frame, and how often their counts changed.

    wall: until each was ready [ms], beside which its stages' own times are kept.
    """
    levels = [(stats.counts["sp_clusters"], stats.counts["vpl_clusters"]) for stats in frames]
    passes = [stats.estimates.get("passes", 1.0) for stats in frames]
    return {
        "frames": len(frames),
        "changes": sum(before != after for before, after in pairwise(zip(levels, passes, strict=True))),
        "light_sets": sum(before[1] != after[1] for before, after in pairwise(levels)),
        "pairs": spread([float(sps * vpls) for sps, vpls in levels]),
        "passes": spread(passes),
        "path_ms": [round(sum(stats.stage_ms.values()), 3) for stats in frames],
        "path_wall_ms": [round(ms, 3) for ms in wall],
        "wall_ms": spread(wall),
        "path_clusters": [f"{sps} {vpls}" for sps, vpls in levels],
        "path_passes": [round(number, 2) for number in passes],
        "path_expected": [float(f"{stats.estimates[f'expected_{unit}']:.4g}") for stats in frames],
    }


def share_at_fewest(errors: Sequence[float], levels: Sequence[str], fewest: str, target: float) -> float:
    """The share of frames that have less error than is within 10 % of `target` though they have the `fewest` counts."""
    below = [error < (1.0 - WITHIN) * target for error in errors]
    return sum(less and level == fewest for less, level in zip(below, levels, strict=True)) / len(errors)


def two_digits(value: float) -> float:
    """A round number near `value`."""
    return float(f"{value:.2g}")


def timed(renderer: Renderer, camera: Camera) -> tuple[Frame, float]:
    """The next frame of a walk, and the time until it is ready [ms]."""
    begun = perf_counter()
    frame = renderer.render(camera, walks=True)
    return frame, 1e3 * (perf_counter() - begun)


def swayed(camera: Camera, extent: float, frame: int) -> Camera:
    """`camera` at a frame of the walk: it turns to its left, to its right and back while it steps ahead and back."""
    angle = 2.0 * np.pi * frame / PERIOD
    ahead = camera.to_world.copy()
    ahead[:3, 3] -= camera.to_world[:3, 2] * (AHEAD * extent * (1.0 - np.cos(angle)) / 2.0)
    return rotated(replace(camera, to_world=ahead), DEGREES * float(np.sin(angle)))


def run(suite: Suite) -> None:
    """The part of the command line."""
    base: dict[str, Any] = {"component": Component.INDIRECT, "lambertian": True}

    def view(name: str, frame: int) -> Camera:
        subject = suite.subject(name)
        return swayed(subject.camera, 1.0 / subject.device_scene.scene.placement.scale, frame)

    @cache
    def usual_ms(name: str) -> float:
        """What frames of the walk take with the default counts, in the median."""
        subject = suite.subject(name)
        renderer = Renderer(subject.device_scene, subject.size, RenderSettings(**base))
        for walks in (False, True, True):
            renderer.render(subject.camera, walks=walks)
        every = [
            timed(renderer, view(name, number))[1] for number in range(QUICK_FRAMES if suite.quick else USUAL_FRAMES)
        ]
        return float(np.median(every))

    def measure_times(name: str, share: float) -> Row:
        subject = suite.subject(name)
        target = two_digits(share * usual_ms(name))
        settings = RenderSettings(**base, target_ms=target)
        renderer = Renderer(subject.device_scene, subject.size, settings)
        for walks in (False, True):
            renderer.render(subject.camera, walks=walks)
        stats, wall = [], []
        for number in range(1, 1 + (QUICK_FRAMES if suite.quick else FRAMES)):
            frame, ms = timed(renderer, view(name, number))
            stats.append(frame.stats)
            wall.append(ms)
        path = path_of(stats, wall, "ms")
        return {
            "scene": name,
            "size": list(subject.size),
            "settings": settings.model_dump(mode="json"),
            "target": {"ms": target},
            "share": share,
            "held": held(wall, target),
            **path,
        }

    vpls = suite.count(ERROR_VPLS)
    frames = QUICK_FRAMES if suite.quick else ERROR_FRAMES
    base_error = {**base, "vpls": vpls, "near_field": False}

    def exact(name: str, number: int, clusters: int) -> Floats:
        """By disks as large as the frame's own clusters make them."""
        subject = suite.subject(name)
        settings = RenderSettings(**base_error, method=Method.EXACT_VPL, vpl_clusters=clusters)
        return Renderer(subject.device_scene, subject.size, settings).render(view(name, number)).radiance()

    @cache
    def reach(name: str) -> tuple[float, float]:
        """The mean errors of the most and of the fewest counts on the walk, each frame from nothing."""
        subject = suite.subject(name)
        levels = levels_of(subject.size[0] * subject.size[1], vpls)
        means = []
        for clusters in (levels.vpl_clusters[-1], levels.vpl_clusters[0]):
            level = levels.usual(clusters)
            counts = {"sp_clusters": level.sp_clusters, "vpl_clusters": clusters}
            renderer = Renderer(subject.device_scene, subject.size, RenderSettings(**base_error, **counts))
            errors = []
            for number in range(REACH_EVERY, 1 + frames, REACH_EVERY):
                frame = renderer.render(view(name, number))
                errors.append(mse(frame.radiance(), exact(name, number, clusters)))
            means.append(float(np.mean(errors)))
        return means[0], means[1]

    def measure_error(name: str, share: float) -> Row:
        subject = suite.subject(name)
        least, most = reach(name)
        target = two_digits(least * (most / least) ** share)
        settings = RenderSettings(**base_error, target_error=target)
        renderer = Renderer(subject.device_scene, subject.size, settings)
        renderer.render(subject.camera)
        levels = levels_of(subject.size[0] * subject.size[1], vpls)
        fewest = min(levels.of(levels.vpl_clusters[0]), key=lambda level: level.work)
        errors, estimates, stats, wall = [], [], [], []
        for number in range(1, 1 + frames):
            frame, ms = timed(renderer, view(name, number))
            stats.append(frame.stats)
            wall.append(ms)
            if number % EVERY == 0:
                errors.append(mse(frame.radiance(), exact(name, number, frame.stats.counts["vpl_clusters"])))
                estimates.append(frame.stats.estimates["expected_error"])
        path = path_of(stats, wall, "error")
        counts = path["path_clusters"][EVERY - 1 :: EVERY]
        return {
            "scene": name,
            "size": list(subject.size),
            "settings": settings.model_dump(mode="json"),
            "target": {"error": target},
            "share": share,
            "held": held(errors, target),
            "running": held(running_means(errors, RUNNING // EVERY), target),
            "estimated": held(estimates, target),
            "errors": errors,
            "below_at_fewest": share_at_fewest(errors, counts, f"{fewest.sp_clusters} {fewest.vpl_clusters}", target),
            "tries": float(np.mean([frame.estimates["tries"] for frame in stats])),
            **path,
        }

    for name in suite.scene_names():
        label = suite.label(name)
        tasks = [
            Task(f"{label} {share:g} of the default's time", partial(measure_times, name, share)) for share in TIMES
        ]
        tasks += [Task(f"{label} {share:.2g} of the errors", partial(measure_error, name, share)) for share in ERRORS]
        suite.run("targets", tasks)
