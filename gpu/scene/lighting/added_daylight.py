"""The sun and the sky of a scene whose file has none, for edits that want them."""

from dataclasses import replace
from math import pi

from gpu.scene.lighting.daylight import level_radiance
from gpu.scene.lighting.default_light import SOFT_SKY
from gpu.scene.types import Environment, Light, LightKind, Rgb, Scene, Sky

SUN_NAME = "sun"
# Irradiance of the sun overhead, of what its sky sends to level ground (the mean of its channels): that of a sun of
# 5778 K and 133 klx above the air, by what gpu.scene.lighting.sun and gpu.scene.lighting.daylight make of a clear day.
SUN_COLOR: Rgb = (3.07, 2.56, 2.11)


def overhead_sun(sky: Sky | Environment | None) -> Light:
    """The sun overhead of a clear day whose sky is as bright as `sky`, or as a soft one where that is None."""
    level = pi * level_radiance(sky or SOFT_SKY)
    red, green, blue = SUN_COLOR
    intensity = level * red, level * green, level * blue
    return Light(SUN_NAME, LightKind.DIRECTIONAL, intensity, direction=(0.0, -1.0, 0.0))


def has_sun(scene: Scene) -> bool:
    """Whether any of its lights is directional."""
    return any(light.kind is LightKind.DIRECTIONAL for light in scene.lights)


def with_daylight(scene: Scene, *, sun: bool, sky: bool) -> Scene:
    """`scene`, which has not what is wanted, with a `sun` overhead after its lights, a soft `sky`; itself without."""
    if not (sun or sky):
        return scene
    lights = (*scene.lights, overhead_sun(scene.sky)) if sun else scene.lights
    return replace(scene, lights=lights, sky=SOFT_SKY if sky else scene.sky)
