"""The job that shows whether an idle worker still works: one pixel of what it rendered last."""

from dataclasses import replace

from gpu.settings import RenderSettings
from server.wire.worker import HEARTBEAT, Render, SceneCamera, SceneRef


def is_warm(last: Render | None, scenes: tuple[SceneRef, ...]) -> bool:
    """Whether a heartbeat renders what was rendered before, from a scene still on the device: that takes no time."""
    return last is not None and last.scene in scenes


def heartbeat(last: Render | None, scenes: tuple[SceneRef, ...], served: SceneRef) -> Render:
    """One pixel of `last`, the job rendered last, while its scene is on the device; else of one that is, or `served`.

    It is rendered anew: a picture kept from before says nothing of the device.
    """
    if last is not None and is_warm(last, scenes):
        job = replace(last, viewer=HEARTBEAT, size=(1, 1), output="none", sample=None)
    else:
        scene = scenes[-1] if scenes else served
        job = Render(HEARTBEAT, scene, SceneCamera(0), (1, 1), RenderSettings(), "none")
    skip = job.settings.skip.model_copy(update={"unchanged_camera": False})
    return replace(job, settings=job.settings.model_copy(update={"skip": skip}))
