"""What a scene needs of kernels: they are compiled without the code for what it has none of, in fewer registers.

Functions ask while they run, as in `if table.sky_count > 0`. A kernel that is made for some `SceneFeatures` writes over
what it asks with a constant, which the compiler follows into all that the kernel calls.
"""

from dataclasses import dataclass

from gpu.device_scene.bsdf import GLOSSY_ROUGHNESS
from gpu.scene.types import AlphaMode, Material, Scene
from gpu.settings import EVERY_SKIP, Skips

# So many punctual lights are cheaper to visit one by one than the noise of a choice among them.
MAX_ENUMERATED = 8


@dataclass(frozen=True)
class SceneFeatures:
    """What may be met in a scene; all of it, when nothing is known.

    alpha: masks that let light through; textures; gloss: lobes so narrow that they get rays of their own;
    triangles: that emit; sky; lights: punctual ones; soft: light that is sampled, not visited light by light.
    """

    alpha: bool = True
    textures: bool = True
    gloss: bool = True
    triangles: bool = True
    sky: bool = True
    lights: bool = True
    soft: bool = True

    @property
    def texels(self) -> bool:
        """Whether images must be read at all."""
        return self.alpha or self.textures

    @property
    def absent_lights(self) -> int:
        """How many kinds of light are left out."""
        return (not self.triangles) + (not self.sky) + (not self.lights)


EVERYTHING = SceneFeatures()


def _glossy(material: Material) -> bool:
    reflects = not material.unlit and (material.specular > 0.0 or material.metallic > 0.0)
    return reflects and (material.roughness < GLOSSY_ROUGHNESS or material.metallic_roughness_slot is not None)


def scene_features(scene: Scene, *, lambertian: bool, skip: Skips = EVERY_SKIP) -> SceneFeatures:
    """What `scene` needs, and what it has none of where `skip` does not make use of that."""
    materials, lights = scene.materials, len(scene.lights)
    alpha = not lambertian and any(material.alpha_mode is not AlphaMode.OPAQUE for material in materials)
    gloss = not lambertian and any(_glossy(material) for material in materials)
    triangles = any(max(material.emission) > 0.0 and not material.unlit for material in materials)
    sky = scene.sky is not None
    every_light = not skip.absent_lights
    return SceneFeatures(
        alpha=alpha or not skip.absent_alpha,
        textures=bool(scene.textures) or not skip.absent_textures,
        gloss=gloss or not skip.absent_gloss,
        triangles=triangles or every_light,
        sky=sky or every_light,
        lights=lights > 0 or every_light,
        soft=triangles or sky or lights > MAX_ENUMERATED or every_light,
    )
