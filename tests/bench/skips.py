"""What each switch saves and what it costs in error: one switch off at a time, against all as they come.

A switch is a yes-or-no of RenderSettings, or of a model inside it: new ones are found here by themselves.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

from pydantic import BaseModel

from gpu.renderer import Renderer
from gpu.settings import Component, RenderSettings
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import STEP_DEGREES, Measured, measure_frames

# Yes-or-nos that say what is rendered, not how.
NOT_SWITCHES = ("lambertian", "indirect_shadows", "antialias")
# What gains nothing while the camera turns.
FOR_STILL_VIEWS = ("skip.unchanged_camera",)


def switches(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    """The names of `model`'s switches; one of a model within it is called FIELD.NAME."""
    for name, field in model.model_fields.items():
        if field.annotation is bool and name not in NOT_SWITCHES:
            yield prefix + name
        elif isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from switches(field.annotation, f"{prefix}{name}.")


def flipped(settings: RenderSettings, switch: str) -> RenderSettings:
    """`settings` with one switch the other way."""
    values: dict[str, Any] = settings.model_dump()
    *models, name = switch.split(".")
    inner = values
    for model in models:
        inner = inner[model]
    inner[name] = not inner[name]
    return RenderSettings.model_validate(values)


def run(suite: Suite) -> None:
    """The part of the command line."""
    settings = suite.settings(component=Component.FULL)
    usual: dict[tuple[str, float], Measured] = {}

    def measured(name: str, choice: RenderSettings, step: float) -> Measured:
        subject = suite.subject(name)
        renderer = Renderer(subject.device_scene, subject.size, choice)
        return measure_frames(renderer, subject.camera, suite.frames, step=step, walks=True)

    def usual_of(name: str, step: float) -> Measured:
        if (name, step) not in usual:
            usual[name, step] = measured(name, settings, step)
        return usual[name, step]

    def measure_row(name: str, switch: str) -> Row:
        subject = suite.subject(name)
        reference = subject.reference(Component.FULL).image
        step = 0.0 if switch in FOR_STILL_VIEWS else STEP_DEGREES
        here, other = usual_of(name, step), measured(name, flipped(settings, switch), step)
        return {
            "scene": name,
            "size": list(subject.size),
            "switch": switch,
            "settings": settings.model_dump(mode="json"),
            "usual": {**here.row(), "errors": suite.errors(here.radiance, reference)},
            "flipped": {**other.row(), "errors": suite.errors(other.radiance, reference)},
            "change": suite.errors(here.radiance, other.radiance),
        }

    tasks = [
        Task(f"{suite.label(name)} {switch}", partial(measure_row, name, switch))
        for switch in switches(RenderSettings)
        for name in suite.scene_names()
    ]
    suite.run("skips", tasks)
