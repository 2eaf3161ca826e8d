"""Whole pictures of scenes with their own materials: metal, gloss, glass and alpha as the files have them.

Pixels whose rays go on past mirrors or clear glass, and the rest, have errors of their own, too.

References are path-traced pictures of these materials, which other parts have of Lambertian surfaces:
`--references DIR`. They show geometric normals, and so do the renders: what curved mirrors and glass show is quite
another thing with those of the file.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import warp as wp

from gpu.device_scene.features import EVERYTHING
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.film.metrics import energy, rel_mse
from gpu.gbuffer.camera_rays import CameraData, camera_data
from gpu.gbuffer.gbuffer import allocate_gbuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.scene.types import Camera, Floats, Mask
from gpu.settings import Component, Method, RenderSettings
from tests.bench.peers import measure_here
from tests.bench.store import Row, Task
from tests.bench.subjects import Size
from tests.bench.suite import Suite
from tests.bench.sweep import title

PATHS = 64  # of `path`; references have eight segments, which are the usual bounces of scenes that shine


def run(suite: Suite) -> None:
    """The part of the command line. Raises UserError where no scene has a reference."""
    names = [name for name in suite.scene_names() if suite.images(name)]
    if not names:
        raise UserError("materials: needs --scenes, and with --references pictures of the files' own materials")
    shown = suite.settings(component=Component.FULL, lambertian=False, bounces=None)
    settings = [shown, shown.model_copy(update={"method": Method.PATH, "samples": PATHS})]
    suite.run(
        "materials",
        [
            Task(f"{suite.label(name)} {title(one)}", partial(measure, suite, name, one))
            for one in settings
            for name in names
        ],
    )


def measure(suite: Suite, name: str, settings: RenderSettings) -> Row:
    """Full light of one choice of settings, and errors of pixels with chains and of the rest."""
    subject = suite.subject(name)
    scene = subject.device_scene.scene
    if scene.normals.any():
        subject.device_scene = DeviceScene(replace(scene, normals=np.zeros_like(scene.normals)), suite.device)
    chained = chained_pixels(subject.device_scene, subject.camera, subject.size)
    reference = subject.reference(Component.FULL).image

    def apart(image: Floats) -> Row:
        parts = {"chained": chained, "rest": ~chained}
        return {part: errors_of_pixels(image, reference, mask) for part, mask in parts.items()}

    return measure_here(suite, name, settings, apart)


def chained_pixels(device_scene: DeviceScene, viewer: Camera, size: Size) -> Mask:
    """Pixels (height, width) in which `viewer` sees something in mirrors or through clear glass."""
    device, faces = device_scene.device, []
    data = camera_data(viewer, device_scene.scene.placement, size[0] / size[1])
    camera = wp.array([data], dtype=CameraData, device=device)
    for lambertian in (False, True):
        gbuffer = allocate_gbuffer(size[0] * size[1], device, EVERYTHING)
        view = device_scene.view(lambertian=lambertian)
        trace_primary_rays(view, camera, size, gbuffer, chain_samples(device))
        faces.append(gbuffer.face.numpy().reshape(size[::-1]))
    solid: Mask = faces[0] != faces[1]
    return solid


def errors_of_pixels(image: Floats, reference: Floats, mask: Mask) -> Row:
    """The share of pixels that are in `mask` (height, width), their relMSE and energy; 0 where there are none."""
    if not mask.any():
        return {"share": 0.0, "rel_mse": 0.0, "energy": 0.0}
    x, r = image[mask][None], reference[mask][None]
    return {"share": float(np.mean(mask)), "rel_mse": rel_mse(x, r), "energy": energy(x, r)}
