"""Whole pictures by `fuzzy-vpl`, by path tracing here and by Mitsuba 3's path tracer: error over time.

Each is compared with path tracing through its own places in a pixel: the centre here, all of it in Mitsuba.
"""

from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np

from gpu.renderer import Renderer
from gpu.scene.types import Floats
from gpu.settings import Component, Method, RenderSettings
from tests.bench import paper
from tests.bench.figures import spread
from tests.bench.mitsuba_peer import MitsubaScene
from tests.bench.store import Row, Task
from tests.bench.subjects import Subject
from tests.bench.suite import BOUNCES, CLUSTERS, VPLS, Suite
from tests.bench.sweep import scaled, title
from tests.bench.timing import LONGEST_SECONDS, load_kernels, measure_frames

PATH_SAMPLES = (1, 4, 16, 64, 256, 1024)
SLOW_SAMPLES, SLOW_FRAMES = 64, 3
COUNTS = (
    {**CLUSTERS, "vpls": VPLS},
    *({"sp_clusters": sps, "vpl_clusters": vpls, "vpls": paper.VPLS} for sps, vpls in paper.SETTINGS),
)


def run(suite: Suite) -> None:
    """The part of the command line."""
    samples = PATH_SAMPLES[:3] if suite.quick else PATH_SAMPLES
    tasks = []
    for counts in COUNTS:
        settings = suite.settings(component=Component.FULL, **scaled(suite, counts))
        tasks += [
            Task(f"{suite.label(name)} {title(settings)}", partial(measure_here, suite, name, settings))
            for name in suite.scene_names()
        ]
    for number in samples:
        settings = suite.settings(component=Component.FULL, method=Method.PATH, samples=number)
        tasks += [
            Task(f"{suite.label(name)} {title(settings)}", partial(measure_here, suite, name, settings))
            for name in suite.scene_names()
        ]
    suite.run("peers", tasks)
    peers: dict[str, MitsubaPeer] = {}

    def measure_mitsuba(name: str, number: int) -> Row:
        if name not in peers:
            peers[name] = MitsubaPeer(suite, suite.subject(name))
        return peers[name].measure(number)

    try:
        import mitsuba  # noqa: F401
    except ImportError:
        print("peers: without Mitsuba, which is not installed: pip install 'lumenwalk[mitsuba]'", flush=True)
        return
    tasks = [
        Task(f"{suite.label(name)} mitsuba samples={number}", partial(measure_mitsuba, name, number))
        for number in samples
        for name in suite.scene_names()
    ]
    suite.run("peers", tasks)


def measure_here(suite: Suite, name: str, settings: RenderSettings,
                 apart: Callable[[Floats], Row] = lambda _: {}) -> Row:  # fmt: skip
    """Full light of one choice of settings. apart: errors of parts of the picture, by name."""
    subject = suite.subject(name)
    reference = subject.reference(Component.FULL)
    load_kernels(subject.device_scene, settings)
    frames = SLOW_FRAMES if (settings.samples or 1) > SLOW_SAMPLES else suite.frames
    measured = measure_frames(Renderer(subject.device_scene, subject.size, settings), subject.camera, frames, 2)
    return {
        "scene": name,
        "size": list(subject.size),
        "method": settings.method.value,
        "settings": settings.model_dump(mode="json"),
        "reference_noise": reference.noise,
        **measured.row(),
        "errors": {"total": suite.errors(measured.radiance, reference.image), **apart(measured.radiance)},
    }


class MitsubaPeer:
    """A scene in Mitsuba with the picture that its renders are compared with."""

    def __init__(self, suite: Suite, subject: Subject) -> None:
        self._suite, self._subject = suite, subject
        self._scene = MitsubaScene(subject.device_scene.scene, subject.size, BOUNCES, cuda=suite.is_cuda)
        self._reference = subject.spread_reference(self._long_render)

    def _long_render(self, samples: int) -> Floats:
        """The mean of pictures small enough for the device's memory."""
        batch = min(samples, 64)
        batches = samples // batch
        total = sum(self._scene.render(batch, 9000 + number)[0].astype(np.float64) for number in range(batches))
        return np.asarray(total / batches, np.float32)

    def measure(self, samples: int) -> Row:
        """Time and error with `samples` paths a pixel; the first picture, which compiles, is not counted."""
        frames = SLOW_FRAMES if samples > SLOW_SAMPLES else self._suite.frames
        self._scene.render(samples, 1)
        times: list[float] = []
        begun = perf_counter()
        while len(times) < frames and (not times or perf_counter() - begun < LONGEST_SECONDS):
            image, ms = self._scene.render(samples, 7000 + len(times))
            times.append(ms)
        own = self._subject.reference(Component.FULL).image
        return {
            "scene": self._subject.name,
            "size": list(self._subject.size),
            "method": "mitsuba",
            "version": self._scene.version,
            "settings": {"samples": samples},
            "frames": len(times),
            "frame_ms": spread(times),
            "errors": {
                "total": self._suite.errors(image, self._reference),
                "reference": self._suite.errors(self._reference, own),
            },
        }
