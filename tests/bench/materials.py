"""Whole pictures of scenes with their own materials: metal, gloss, glass and alpha as the files have them.

References are path-traced pictures of these materials, which other parts have of Lambertian surfaces:
`--references DIR`. They show geometric normals, renders those of the file, which few scenes tell apart.
"""

from functools import partial

from gpu.errors import UserError
from gpu.settings import Component, Method
from tests.bench.peers import measure_here
from tests.bench.store import Task
from tests.bench.suite import Suite
from tests.bench.sweep import title

PATHS, BOUNCES = 64, 6  # of `path`, whose references have eight segments


def run(suite: Suite) -> None:
    """The part of the command line. Raises UserError where no scene has a reference."""
    names = [name for name in suite.scene_names() if suite.images(name)]
    if not names:
        raise UserError("materials: needs --scenes, and with --references pictures of the files' own materials")
    shown = suite.settings(component=Component.FULL, lambertian=False)
    settings = [shown, shown.model_copy(update={"method": Method.PATH, "samples": PATHS, "bounces": BOUNCES})]
    suite.run(
        "materials",
        [
            Task(f"{suite.label(name)} {title(one)}", partial(measure_here, suite, name, one))
            for one in settings
            for name in names
        ],
    )
