"""The parts of the error of `fuzzy-vpl`: bias and noise of the VPLs, bias and noise of clustering, by several seeds."""

from dataclasses import asdict
from functools import partial

from gpu.settings import Component
from tests.bench import paper
from tests.bench.figures import tell_apart
from tests.bench.store import Row, Task
from tests.bench.suite import CLUSTERS, VPLS, Suite

SEEDS = 3
# The default with the paper's number of VPLs comes first: exact-vpl takes a tenth of the time.
SETTINGS = ({"vpls": paper.VPLS, **CLUSTERS}, {"vpls": VPLS, **CLUSTERS})


def measure_row(suite: Suite, name: str, counts: dict[str, int]) -> Row:
    """The error parts of one scene with these counts."""
    subject = suite.subject(name)
    reference = subject.reference(Component.INDIRECT)
    settings = [suite.settings(**counts, seed=seed) for seed in range(SEEDS)]
    exact = [subject.exact(choice).image for choice in settings]
    clustered = [subject.render(choice) for choice in settings]
    return {
        "scene": name,
        "size": list(subject.size),
        "seeds": SEEDS,
        "settings": settings[0].model_dump(mode="json"),
        "rel_mse": asdict(tell_apart(clustered, exact, reference.image, reference.noise)),
    }


def run(suite: Suite) -> None:
    """The part of the command line."""
    choices = [{key: suite.count(number) for key, number in counts.items()} for counts in SETTINGS]
    tasks = [
        Task(f"{suite.label(name)} vpls={counts['vpls']}", partial(measure_row, suite, name, counts))
        for counts in choices
        for name in suite.scene_names()
    ]
    suite.run("decompose", tasks)
