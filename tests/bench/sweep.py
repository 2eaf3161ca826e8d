"""Times and errors of indirect light over clusters, VPLs, fuzziness and weighting; most telling rows first.

Total error is against path tracing. Clustering error is against `exact-vpl` with the same VPLs, their disks as the
row's own clusters make them, and neither picture has near-field light, which clusters have no part in. The groups are
the paper's figures where they have its names.
"""

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from gpu.renderer import Renderer
from gpu.scene.types import Floats
from gpu.settings import Clustering, Component, Method, RenderSettings, Weighting
from tests.bench import paper
from tests.bench.store import Row, Task
from tests.bench.subjects import Subject
from tests.bench.suite import CLUSTERS, VPLS, Suite
from tests.bench.timing import Measured, light_times, load_kernels, measure_frames

REFERENCES = (Method.EXACT_VPL, Method.PATH)
VPL_COUNTS = (2000, 8000, 32_000, VPLS, 262_144)
# More VPLs than this are too slow one by one: their rows have no clustering error.
MOST_EXACT_VPLS = 100_000
PATH_SAMPLES = (1, 4, 16, 64)
# What a camera in motion turns by from frame to frame: at 60 frames a second, a look around takes twelve seconds.
MOTION_DEGREES = 0.5
LIGHT_REPEATS = 20


def groups() -> Iterator[tuple[str, dict[str, Any]]]:
    """Every (group, changes of settings) of the sweep in the order of worth; some come in several groups."""
    for method in Method:
        if method not in REFERENCES:
            yield "default", {"method": method, "vpls": VPLS}
    middle = {"sp_clusters": 8000, "vpl_clusters": 2000, "vpls": paper.VPLS}
    for sps, vpls in paper.SETTINGS:
        yield "paper", {"sp_clusters": sps, "vpl_clusters": vpls, "vpls": paper.VPLS}
    yield "exact", {"method": Method.EXACT_VPL, "vpls": paper.VPLS}
    for samples in PATH_SAMPLES:
        yield "path", {"method": Method.PATH, "samples": samples}
    for fuzziness, weighting in product((6, 1, 2, 4, 8), Weighting):
        yield "fuzziness", {**middle, "fuzziness": fuzziness, "weighting": weighting}
    for vpls in VPL_COUNTS:
        yield "vpls", {"vpls": vpls}
        if vpls <= MOST_EXACT_VPLS:
            yield "exact", {"method": Method.EXACT_VPL, "vpls": vpls}
    for sps in paper.SP_CLUSTERS:
        yield "sps", {"clustering": Clustering.SPS, "sp_clusters": sps, "vpls": paper.VPLS}
    for vpls in paper.VPL_CLUSTERS:
        yield "vpl-clusters", {"clustering": Clustering.VPLS, "vpl_clusters": vpls, "vpls": paper.VPLS}
    corners = {(1000, 4000), (30_000, 750), (8000, 750), (8000, 4000), (1000, 2000), (30_000, 2000)}
    grid = list(product(paper.BOTH_SP_CLUSTERS, paper.BOTH_VPL_CLUSTERS))
    for sps, vpls in sorted(grid, key=lambda cell: cell not in corners):
        yield "both", {"sp_clusters": sps, "vpl_clusters": vpls, "vpls": paper.VPLS}


def choices(suite: Suite) -> dict[RenderSettings, list[str]]:
    """The groups of each of the sweep's settings; only those with a group that the run asks for, if it does."""
    table: dict[RenderSettings, list[str]] = {}
    for group, changes in groups():
        names = table.setdefault(suite.settings(**scaled(suite, changes)), [])
        if group not in names:
            names.append(group)
    return {choice: names for choice, names in table.items() if not suite.groups or {*suite.groups} & {*names}}


def scaled(suite: Suite, changes: dict[str, Any]) -> dict[str, Any]:
    """`changes` with the counts of this run."""
    return changes | {name: suite.count(changes[name]) for name in (*CLUSTERS, "vpls") if name in changes}


def title(settings: RenderSettings) -> str:
    """Settings in a row's key."""
    if settings.method is Method.PATH:
        return f"path samples={settings.samples}"
    if settings.method is Method.EXACT_VPL:
        return f"exact-vpl vpls={settings.vpls}"
    return (
        f"{settings.method.value} clustering={settings.clustering.value} sps={settings.sp_clusters} "
        f"vpl-clusters={settings.vpl_clusters} vpls={settings.vpls} F={settings.fuzziness} {settings.weighting.value}"
    )


def tasks(suite: Suite) -> list[Task]:
    """All settings, each for all scenes before the next."""
    return [
        Task(f"{suite.label(name)} {title(settings)}", partial(measure_row, suite, name, settings, names))
        for settings, names in choices(suite).items()
        for name in suite.scene_names()
    ]


def measure_row(suite: Suite, name: str, settings: RenderSettings, names: list[str]) -> Row:
    """Times and errors of one choice of settings for one scene."""
    subject = suite.subject(name)
    row = {
        "scene": name,
        "size": list(subject.size),
        "triangles": len(subject.device_scene.scene.triangles),
        "groups": names,
        "settings": settings.model_dump(mode="json"),
    }
    reference = subject.reference(Component.INDIRECT)
    row["reference_noise"] = reference.noise
    if settings.method is Method.EXACT_VPL:
        exact = subject.exact(settings)
        times = {"median": exact.ms, "p5": exact.ms, "p95": exact.ms}
        return {**row, "frames": 1, "frame_ms": times, "errors": {"total": suite.errors(exact.image, reference.image)}}
    if settings.method is Method.PATH:
        load_kernels(subject.device_scene, settings)
    walk = partial(measure_walk, suite, subject)
    measured = walk(settings)
    row |= measured.row()
    if "default" in names or "paper" in names:
        row["light_ms"] = light_times(subject.device_scene, settings, min(LIGHT_REPEATS, suite.frames))

    def errors(image: Floats, *, moves: bool = False) -> dict[str, Any]:
        found = {"total": suite.errors(image, reference.image)}
        if settings.method is not Method.PATH and (settings.vpls or 0) <= MOST_EXACT_VPLS:
            bare = settings.model_copy(update={"near_field": False})
            image = walk(bare, moves=True).radiance if moves else subject.render(bare)
            found["clustering"] = suite.errors(image, subject.exact(bare).image)
        return found

    if "default" in names:
        moving = walk(settings, moves=True)
        row["motion"] = {**moving.row(), "errors": errors(moving.radiance, moves=True)}
    return {**row, "errors": errors(measured.radiance)}


def measure_walk(suite: Suite, subject: Subject, settings: RenderSettings, *, moves: bool = False) -> Measured:
    """Frames that each begin from nothing, or of a camera that `moves`."""
    renderer = Renderer(subject.device_scene, subject.size, settings)
    if moves:
        return measure_frames(renderer, subject.camera, suite.frames, step=MOTION_DEGREES, walks=True)
    return measure_frames(renderer, subject.camera, suite.frames)


def run(suite: Suite) -> None:
    """The part of the command line."""
    suite.run("sweep", tasks(suite))
