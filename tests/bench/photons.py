"""`photon-gather` beside its paper, fuzzy-vpl and path tracing: times and errors of indirect light, and growth.

At the counts of the paper's Table 1, also without its cut (its Fig. 6); then over photons, gather rays and nodes of the
cut, one of them changed at a time. The paper's pictures have 1024 × 1024 pixels: `--size 1024x1024`.
"""

from functools import partial
from typing import Any

from gpu.renderer import Renderer
from gpu.settings import Component, Method, RenderSettings
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import load_kernels, measure_frames

# Of the paper's kitchen, the largest of its scenes, which it shows at 1.5 frames a second.
PAPER = {"photons": 470_000, "sp_clusters": 5000, "cut_nodes": 8192, "gather_rays": 500}
GROWTH = {
    "photons": (10_000, 100_000, 1_000_000, 4_000_000),
    "gather_rays": (64, 256, 1024),
    "cut_nodes": (1024, 4096, 16_384, 65_536),
}


def choices(suite: Suite) -> list[dict[str, Any]]:
    """Settings that are measured: the paper's, with and without the cut, grown ones, and other methods'."""
    here = {"method": Method.PHOTON_GATHER, **{name: suite.count(count) for name, count in PAPER.items()}}
    grown = [{**here, name: suite.count(count)} for name, counts in GROWTH.items() for count in counts]
    others = [{"method": Method.FUZZY_VPL}, *({"method": Method.PATH, "samples": samples} for samples in (1, 4, 16))]
    return [here, {**here, "cut_nodes": 0}, *grown, *others]


def measure(suite: Suite, name: str, settings: RenderSettings) -> Row:
    """Frames of a walk by one choice of settings: times of stages, and errors against path tracing."""
    subject = suite.subject(name)
    load_kernels(subject.device_scene, settings)
    renderer = Renderer(subject.device_scene, subject.size, settings)
    measured = measure_frames(renderer, subject.camera, suite.frames, walks=True)
    errors = suite.errors(measured.radiance, subject.reference(Component.INDIRECT).image)
    told = settings.model_dump(mode="json", include={"method", "clustering", "samples", *PAPER})
    return {"scene": name, "size": list(subject.size), **told, **measured.row(), "errors": errors}


def run(suite: Suite) -> None:
    """The part of the command line."""
    tasks = []
    for name in suite.scene_names():
        for choice in choices(suite):
            settings = suite.settings(component=Component.INDIRECT, **choice)
            label = " ".join(str(value) for value in choice.values())
            tasks.append(Task(f"{suite.label(name)} {label}", partial(measure, suite, name, settings)))
    suite.run("photons", tasks)
