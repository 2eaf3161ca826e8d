"""A scene with a picture of light all around, in place of what its file has there."""

from dataclasses import replace

import numpy as np

from gpu.scene.lighting.default_light import without_default_light
from gpu.scene.types import Environment, Scene

EVEN = Environment("even", np.ones((1, 2, 3), np.float32))
"""For who only asks what there is, not how it looks."""


def surrounded(scene: Scene, environment: Environment) -> Scene:
    """`scene` in an environment, instead of its sky, also one of triangles, and of added light."""
    seen = ~np.array([material.backdrop for material in scene.materials])[scene.triangle_material]
    return replace(
        without_default_light(scene),
        triangles=scene.triangles[seen],
        triangle_material=scene.triangle_material[seen],
        sky=environment,
    )
