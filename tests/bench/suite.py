"""What every part of the suite is given: the options, the scenes, and a place for rows."""

from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from gpu.core.device import choose_device
from gpu.settings import Component, RenderSettings
from tests.bench.errors import ErrorPool, errors_of
from tests.bench.store import Budget, Results, Row, Task, environment, read_rows, run_tasks
from tests.bench.subjects import Size, Subject, load_subject, reference_size, scene_names

# The default counts of a GPU, also where a CPU is measured; `quick` has so much less of everything.
CLUSTERS = {"sp_clusters": 8192, "vpl_clusters": 2048}
VPLS = 98_304
BOUNCES = 4  # of the references
QUICK_SHARE, LEAST = 32, 8
# The scene of tests.bench.hall, which goes with all others.
HALL = "hall"


@dataclass
class Suite:
    """Options of a run; see the command line's help."""

    out: Path
    cache: Path
    device: str | None = None
    scenes: Path | None = None
    references: Path | None = None
    names: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    size: Size = (1024, 720)
    quick: bool = False
    reference_samples: int | None = None
    page_file: Path | None = None
    budget: Budget = field(default_factory=lambda: Budget(None))
    _subjects: dict[str, Subject] = field(default_factory=dict)
    _pool: ErrorPool = field(default_factory=ErrorPool)

    def __post_init__(self) -> None:
        self._device = choose_device(self.device)

    @property
    def page(self) -> Path:
        """The file of the page of results."""
        return self.page_file or self.out / "results.md"

    @property
    def images_folder(self) -> Path:
        """The folder of the page's images, and of nothing else."""
        return self.page.with_suffix("")

    def measured(self) -> dict[str, list[Row]]:
        """The rows of each part that was measured, of the scenes that were named if any were."""
        files = sorted(self.out.glob("*.json"))
        rows = {file.stem: read_rows(file) for file in files}
        wanted = {*self.names, HALL} if self.names else None
        return {part: [row for row in own if not wanted or row["scene"] in wanted] for part, own in rows.items()}

    def tried(self) -> str:
        """What somebody wrote about what was tried; empty where nobody did."""
        notes = self.out / "tried.md"
        return notes.read_text() if notes.exists() else ""

    @property
    def is_cuda(self) -> bool:
        """Whether this measures a GPU."""
        return bool(self._device.is_cuda)

    @property
    def frames(self) -> int:
        """Frames that a time is the median of."""
        return 4 if self.quick else 25

    def scene_names(self) -> tuple[str, ...]:
        """The scenes to measure."""
        return self.names or tuple(scene_names(self.scenes))

    def images(self, name: str) -> Path | None:
        """The file of path-traced pictures of a scene, if there is one."""
        path = self.references / f"{name}.npz" if self.scenes and self.references else None
        return path if path and path.exists() else None

    def size_of(self, name: str) -> Size:
        """The size that a scene is rendered at: its reference's, or the one that was asked for."""
        images = self.images(name)
        return reference_size(images) if images else self.size

    def label(self, name: str) -> str:
        """Name and size of a scene, as keys of rows begin."""
        width, height = self.size_of(name)
        return f"{name} {width}x{height}"

    def subject(self, name: str) -> Subject:
        """A scene, loaded once."""
        if name not in self._subjects:
            samples = self.reference_samples or (32 if self.quick else 4096 if self.is_cuda else 256)
            self._subjects[name] = load_subject(
                name, self.scenes, self.images(name), self.size_of(name), self.device, self.cache, samples
            )
        return self._subjects[name]

    def count(self, number: int) -> int:
        """A count of the full suite, or much less when this run is quick."""
        return max(LEAST, number // QUICK_SHARE) if self.quick else number

    def settings(self, **changes: Any) -> RenderSettings:
        """The suite's base: indirect light, Lambertian surfaces, a GPU's default counts; with `changes`.

        Frames of walks are of pixels' centres, and light has as many bounces, as those of the references.
        """
        counts = {name: self.count(number) for name, number in CLUSTERS.items()} | {"vpls": self.count(VPLS)}
        base = {"component": Component.INDIRECT, "lambertian": True, "bounces": BOUNCES, "antialias": False, **counts}
        return RenderSettings.model_validate(base | changes)

    def errors(self, render: ArrayLike, reference: ArrayLike) -> Future[Row] | Row:
        """Every error of gpu.film.metrics; on a GPU computed by other processes while it goes on."""
        # On a CPU they would take the time that is measured.
        return self._pool.submit(render, reference) if self.is_cuda else errors_of(render, reference)

    def run(self, part: str, tasks: list[Task]) -> None:
        """Measure the part's missing rows into OUT/PART.json."""
        results = Results(self.out / f"{part}.json", environment(self._device))
        run_tasks(tasks, results, self.budget, lambda text: print(f"{part}: {text}", flush=True))
