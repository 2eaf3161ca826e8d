"""All parts in about twenty minutes of an H100: what is dear is measured in fewer scenes, what tells most comes first.

Goes on where an earlier run of the same commit stopped, as every part does; with `--seconds` the rest is left for
another run. A step that fails is told, and the others still run.
"""

from dataclasses import dataclass, replace
from importlib import import_module
from time import perf_counter
from traceback import print_exc

from gpu.errors import UserError
from tests.bench import paper
from tests.bench.suite import Suite

WALK_SIZE = (1280, 720)
PAPER_SCENES = ("conference", "cornell-box", "living-room")


@dataclass(frozen=True)
class Step:
    """A part, the scenes (all if none is named; names as in the paper) and groups of it, and its most seconds."""

    part: str
    seconds: float
    scenes: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()


STEPS = (
    Step("sweep", 220.0, groups=("default", "paper")),
    Step("walk", 30.0),
    Step("still", 150.0),
    Step("targets", 90.0, (*PAPER_SCENES, "sponza")),
    Step("skips", 70.0, ("conference", "sponza", "veach-bidir")),
    Step("floors", 30.0),
    Step("pictures", 30.0),
    Step("growth", 70.0, ("living-room",)),
    Step("temporal", 45.0, ("conference", "living-room")),
    Step("decompose", 40.0),
    Step("sweep", 50.0, PAPER_SCENES, ("path",)),
    Step("sweep", 60.0, PAPER_SCENES, ("exact", "vpls")),
    Step("sweep", 30.0, ("living-room",), ("sps",)),
    Step("sweep", 40.0, ("cornell-box",), ("vpl-clusters",)),
    Step("sweep", 60.0, ("conference",), ("both",)),
    Step("sweep", 30.0, ("conference",), ("fuzziness",)),
    Step("peers", 45.0, PAPER_SCENES),
)


def run(suite: Suite) -> None:
    """The part of the command line. Raises UserError when a step failed."""
    failed = []
    for step in STEPS:
        begun = perf_counter()
        try:
            import_module(f"tests.bench.{step.part}").run(suite_of(suite, step))
        except UserError:
            raise
        except Exception:
            print_exc()
            failed.append(step.part)
        text = " ".join((step.part, *step.groups))
        print(f"survey: {text} took {perf_counter() - begun:.0f} of {step.seconds:.0f} s", flush=True)
    if failed:
        raise UserError(f"survey: {', '.join(failed)} failed, see above; the other parts were measured")


def suite_of(suite: Suite, step: Step) -> Suite:
    """The suite as a step has it: its share of time, its groups, and those of its scenes that there are."""
    budget = suite.budget.at_most(step.seconds)
    if step.part == "walk":
        size = suite.size if suite.quick else WALK_SIZE
        return replace(suite, budget=budget, scenes=None, references=None, names=(), size=size, _subjects={})
    there = suite.scene_names()
    names = tuple(name for name in there if not step.scenes or paper.paper_scene(name) in step.scenes)
    return replace(suite, budget=budget, names=names or there[:1], groups=step.groups)
