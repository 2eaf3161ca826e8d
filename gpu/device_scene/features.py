"""What a scene has, so that kernels are compiled without the code for what it has not, in fewer registers.

gpu.device_scene.specialisation makes such kernels.
"""

from dataclasses import dataclass, replace

from gpu.device_scene.bsdf import BSDF_PARAMETERS
from gpu.device_scene.surface import SURFACE_PARAMETERS
from gpu.scene.types import CLEAR_ROUGHNESS, AlphaMode, Environment, Material, Scene

# So many punctual lights are cheaper to visit one by one than the noise of a choice among them.
MAX_ENUMERATED = 8
# Of two emitters, or fewer, samples are evenly spread over both.
ONE_LAMP = 2
# Of surfaces that are there in part, rays that do not draw meet those of which there is more; interpolation rounds.
SHEER = 0.5 + 1.0e-3


@dataclass(frozen=True)
class SceneFeatures:
    """What rays may meet in a scene; all of it, when nothing is known.

    masks: triangles that may be there in part, which rays look for apart; alpha: and let light through; cutouts: as
    `has_cutouts` tells; blend: surfaces that are there in part; sheer: as `has_sheer` tells; glass: any that transmits;
    panes: as `is_pane` tells; part_glass: as Material.is_part_glass tells; textures; one_sided: backs that cameras do
    not see; backdrop: a sky of triangles;
    gloss: lobes so narrow that they get rays of their own;
    environment: a picture of the light around; soft: as `has_soft_light` tells; lamps: as `has_several_lamps` tells;
    specular: as `has_specular` tells; frosted: glass that scatters what goes through, or is in part something else;
    coats: clear ones over other surfaces, which are glossy; focus: as `casts_by_lobe` tells; sheen: fibres on surfaces;
    films: thin ones, which have colours; grain: of facets, as of brushed metal; translucent: surfaces that scatter
    light to their other side; dispersion: as Material.is_dispersive tells; constants: whether kernels are told by
    constants what none of these is (gpu.device_scene.specialisation), as those for GPUs are.
    """

    masks: bool = True
    alpha: bool = True
    cutouts: bool = True
    blend: bool = True
    sheer: bool = True
    glass: bool = True
    panes: bool = True
    textures: bool = True
    one_sided: bool = True
    backdrop: bool = True
    gloss: bool = True
    environment: bool = True
    soft: bool = True
    lamps: bool = True
    specular: bool = True
    frosted: bool = True
    coats: bool = True
    focus: bool = True
    sheen: bool = True
    films: bool = True
    grain: bool = True
    translucent: bool = True
    dispersion: bool = True
    part_glass: bool = True
    constants: bool = True

    @property
    def lobes(self) -> bool:
        """Whether pixels have rays of lobes that are narrower than matt."""
        return self.gloss or self.frosted

    @property
    def caustics(self) -> bool:
        """Whether some surfaces send light of emitters on to others as no matt one would."""
        return self.specular or self.focus

    @property
    def see_through(self) -> bool:
        """Whether cameras see past surfaces, of which they show something, too."""
        return self.specular or self.blend

    @property
    def reads_light(self) -> bool:
        """Whether rays end in the light that VPLs know."""
        return self.lobes or self.see_through or self.translucent


EVERYTHING = SceneFeatures()


def features_of_any(has: SceneFeatures) -> SceneFeatures:
    """What is told to general kernels and arrays for a scene that `has` these: all, but for what lights there are,
    which decide no kernel, but which are launched, and with what samples; and but for frosted glass, clear coats,
    cloth, thin films, grain, what is translucent and dispersion, which few scenes have, and which take most of the time
    that all compile.
    """
    return replace(
        EVERYTHING,
        soft=has.soft,
        lamps=has.lamps,
        frosted=has.frosted,
        coats=has.coats,
        sheen=has.sheen,
        films=has.films,
        grain=has.grain,
        translucent=has.translucent,
        dispersion=has.dispersion,
    )


def _coated(material: Material) -> bool:
    return material.clearcoat > 0.0 and not material.unlit


def _glossy(material: Material) -> bool:
    if _coated(material):
        return True
    reflects = not material.unlit and (material.specular > 0.0 or material.metallic > 0.0)
    return reflects and (
        material.roughness < BSDF_PARAMETERS.glossy_roughness or material.metallic_roughness_slot is not None
    )


def is_specular(material: Material) -> bool:
    """Whether a surface of `material` may be a perfect mirror or clear glass, at least in part."""
    if material.unlit or material.backdrop:
        return False
    textured = material.metallic_roughness_slot is not None
    clear = material.transmission > 0.0 and (textured or material.roughness <= CLEAR_ROUGHNESS)
    mirror = material.metallic == 1.0 and not material.has_grain
    return clear or (mirror and (textured or material.roughness < SURFACE_PARAMETERS.mirror))


def _frosted(material: Material) -> bool:
    in_part = material.is_part_glass and material.glass_share < 1.0
    mixed = in_part or material.transmission_slot is not None or not material.is_clear
    return material.transmission > 0.0 and mixed and not material.unlit


def casts_by_lobe(material: Material) -> bool:
    """Whether a surface of `material` may send light on in a narrow lobe that is strong enough to cast caustics."""
    if material.unlit or material.backdrop:
        return False
    textured, narrow = material.metallic_roughness_slot is not None, BSDF_PARAMETERS.glossy_roughness
    if _frosted(material) and (textured or CLEAR_ROUGHNESS < material.roughness < narrow):
        return True
    face = ((material.ior - 1.0) / (material.ior + 1.0)) ** 2 * material.specular * max(material.specular_color)
    mirror = material.metallic == 1.0 and material.roughness < SURFACE_PARAMETERS.mirror and not material.has_grain
    lobe = textured or (material.roughness < narrow and not mirror)
    return lobe and (material.has_film or max(material.metallic, face) > BSDF_PARAMETERS.faint)


def has_specular(scene: Scene) -> bool:
    """Whether `scene` has mirrors or clear glass, which its camera looks past."""
    return any(is_specular(material) for material in scene.materials)


def is_in_part(material: Material) -> bool:
    """Whether surfaces of `material` may be there in part, by alpha or as glass."""
    return material.alpha_mode is not AlphaMode.OPAQUE or material.is_part_glass


def is_pane(material: Material) -> bool:
    """Whether surfaces of `material` are faces of clear bodies of glass, which indirect light passes."""
    return material.is_clear and not material.is_part_glass


def triangle_group(material: Material) -> int:
    """The group of triangles that those of `material` are in, by SceneData's order."""
    if material.backdrop:
        return 3
    return 2 if is_in_part(material) else int(is_pane(material))


def has_blend(scene: Scene) -> bool:
    """Whether `scene` has surfaces of which rays find a share: of BLEND, or part glass."""
    return any(material.alpha_mode is AlphaMode.BLEND or material.is_part_glass for material in scene.materials)


def has_cutouts(scene: Scene) -> bool:
    """Whether textures or vertices tell how much there is of some surfaces of `scene`."""
    parts = [material for material in scene.materials if material.alpha_mode is not AlphaMode.OPAQUE]
    return any(_least_alpha(scene, material) < material.base_color[3] for material in parts)


def has_sheer(scene: Scene) -> bool:
    """Whether `scene` has surfaces of which less than half may be there: cameras look past these."""
    blends = [material for material in scene.materials if material.alpha_mode is AlphaMode.BLEND]
    glass = any(material.is_part_glass for material in scene.materials)
    return glass or any(_least_alpha(scene, material) < SHEER for material in blends)


def _least_alpha(scene: Scene, material: Material) -> float:
    """The least alpha that a `material` may have in `scene`."""
    slot, least = material.base_color_slot, material.base_color[3]
    if slot is not None:
        least *= scene.textures[slot.texture].least_alpha
    return least * scene.least_vertex_alpha


def has_soft_light(scene: Scene) -> bool:
    """Whether `scene` has light that is sampled, not visited light by light, so that it is noisy and smoothed."""
    emits = any(material.emits for material in scene.materials)
    return emits or scene.sky is not None or len(scene.lights) > MAX_ENUMERATED


def has_several_lamps(scene: Scene) -> bool:
    """Whether sampled light is of more than the two triangles of a rectangle or the sky: whether there is a choice."""
    triangles = sum(scene.material_triangles[n] for n, material in enumerate(scene.materials) if material.emits)
    lights = len(scene.lights) if len(scene.lights) > MAX_ENUMERATED else 0
    return bool(triangles + (scene.sky is not None) + lights > ONE_LAMP)


def scene_features(scene: Scene, *, lambertian: bool, constants: bool = True, assume_alpha: bool = False,
                   assume_textures: bool = False, assume_gloss: bool = False) -> SceneFeatures:  # fmt: skip
    """What `scene` has, and what is to be assumed of it. lambertian: its surfaces are opaque and Lambertian; constants:
    as of SceneFeatures.
    """
    materials = scene.materials
    masks = any(is_in_part(material) for material in materials)
    gloss = not lambertian and any(_glossy(material) for material in materials)
    return SceneFeatures(
        masks=masks or assume_alpha,
        alpha=(masks and not lambertian) or assume_alpha,
        cutouts=(not lambertian and has_cutouts(scene)) or assume_alpha,
        blend=not lambertian and has_blend(scene),
        sheer=not lambertian and has_sheer(scene),
        glass=not lambertian and any(material.transmission > 0.0 for material in materials),
        panes=not lambertian and any(is_pane(material) and not material.backdrop for material in materials),
        textures=bool(scene.textures) or assume_textures,
        one_sided=not lambertian and any(material.double_sided is False for material in materials),
        backdrop=any(material.backdrop for material in materials),
        gloss=gloss or assume_gloss,
        environment=isinstance(scene.sky, Environment),
        soft=has_soft_light(scene),
        lamps=has_several_lamps(scene),
        specular=not lambertian and has_specular(scene),
        frosted=not lambertian and any(_frosted(material) for material in materials),
        coats=not lambertian and any(_coated(material) for material in materials),
        focus=not lambertian and any(casts_by_lobe(material) for material in materials),
        sheen=not lambertian and any(material.has_sheen for material in materials),
        films=not lambertian and any(material.has_film for material in materials),
        grain=not lambertian and any(material.has_grain for material in materials),
        translucent=not lambertian and any(material.is_translucent for material in materials),
        dispersion=not lambertian and any(material.is_dispersive for material in materials),
        part_glass=not lambertian and any(material.is_part_glass for material in materials),
        constants=constants,
    )
