"""Materials of a stage: UsdPreviewSurface as metallic-roughness (https://openusd.org/release/spec_usdpreviewsurface.html)."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gpu.scene.formats.usd.stage import Stage
from gpu.scene.formats.usd.textures import Textures, UvTexture, is_shader
from gpu.scene.types import AlphaMode, Material, Rgb, TextureSlot
from gpu.scene.validate import check_count

_GREY = (0.18, 0.18, 0.18)
_RGB = 4
_OUTPUTS = {"r": 0, "g": 1, "b": 2, "a": 3, "rgb": _RGB}
_UNUSED = {"clearcoat": 0.0, "displacement": 0.0, "occlusion": 1.0}


@dataclass(frozen=True)
class Look:
    """A material's number in the scene, the primvars that place its textures, and whether displayColor tints it."""

    number: int
    uv_names: tuple[str, ...] = ()
    colored: bool = False


@dataclass
class Materials:
    """The materials that a stage's prims use, each made when first bound."""

    stage: Stage
    materials: list[Material] = field(default_factory=list)
    textures: Textures = field(init=False)
    _looks: dict[tuple[str, bool, bool, bool], Look] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.textures = Textures(self.stage)

    def look(self, bound: Any, double_sided: bool, colored: bool, translucent: bool) -> Look:
        """How a prim with the material `bound` looks. Raises SceneError.

        colored, translucent: whether the prim has a displayColor and a displayOpacity.
        """
        key = (str(bound.GetPath()) if bound else "", double_sided, colored, translucent)
        if key not in self._looks:
            self._looks[key] = self._made(bound, double_sided, colored, translucent)
        return self._looks[key]

    def add(self, material: Material) -> int:
        """The number of a material of the scene's own, such as a light's."""
        self.materials.append(material)
        limits = self.stage.limits
        check_count(str(self.stage.path), "materials", len(self.materials), limits.max_materials, "max_materials")
        return len(self.materials) - 1

    def _made(self, bound: Any, double_sided: bool, colored: bool, translucent: bool) -> Look:
        surface = bound.ComputeSurfaceSource()[0] if bound else None
        if not surface or surface.GetShaderId() != "UsdPreviewSurface":
            if bound:
                self.stage.remarks.add(
                    "materials without a UsdPreviewSurface are shown by displayColor", str(bound.GetPath())
                )
            color = (1.0, 1.0, 1.0) if colored else _GREY
            plain = Material(
                "displayColor",
                (*color, 1.0),
                0.0,
                0.5,
                alpha_mode=AlphaMode.BLEND if translucent else AlphaMode.OPAQUE,
                double_sided=double_sided,
            )
            return Look(self.add(plain), (), True)
        preview = Preview(self, surface)
        material = preview.material(bound.GetPath().name, double_sided)
        return Look(self.add(material), tuple(preview.uv_names), preview.colored)


@dataclass
class Preview:
    """One UsdPreviewSurface. uv_names: the primvars that place its textures; colored: whether displayColor tints it."""

    owner: Materials
    shader: Any
    uv_names: list[str] = field(default_factory=list)
    colored: bool = False

    def material(self, name: str, double_sided: bool) -> Material:
        """The material. Raises SceneError when a texture is broken, too large or outside the scene's folder."""
        for unused, default in _UNUSED.items():
            if self._value(unused, default) != default or self._source(unused):
                self.owner.stage.remarks.add(f"{unused} of materials is not shown")
        color, color_slot, alpha_mode = self._base()
        emission, emission_slot = self._color("emissiveColor", (0.0, 0.0, 0.0))
        metallic, roughness, surface_slot = self._metallic_roughness()
        ior = max(self._value("ior", 1.5), 1.0)
        specular_color = (1.0, 1.0, 1.0)
        if int(self._value("useSpecularWorkflow", 0)):
            wanted, slot = self._color("specularColor", (0.0, 0.0, 0.0))
            if slot:
                self.owner.stage.remarks.add("textures of specularColor are not supported: white counts")
            normal_reflectance = max(((ior - 1.0) / (ior + 1.0)) ** 2, 1e-6)
            specular_color = _rgb([value / normal_reflectance for value in wanted])
            metallic = 0.0
        return Material(
            name=name,
            base_color=color,
            metallic=metallic,
            roughness=roughness,
            emission=emission,
            base_color_slot=color_slot,
            metallic_roughness_slot=surface_slot,
            normal_slot=self._normal(),
            emission_slot=emission_slot,
            alpha_mode=alpha_mode,
            alpha_cutoff=self._value("opacityThreshold", 0.0) or 0.5,
            double_sided=double_sided,
            ior=ior,
            specular_color=specular_color,
        )

    def _base(self) -> tuple[tuple[float, float, float, float], TextureSlot | None, AlphaMode]:
        """Base colour with alpha, its texture, and how alpha is read."""
        opacity = self._source("opacity")
        texture = self._source("diffuseColor")
        alpha = opacity if isinstance(opacity, tuple) else float(self._value("opacity", 1.0))
        mode = AlphaMode.OPAQUE
        if isinstance(alpha, tuple) or alpha < 1.0:
            mode = AlphaMode.MASK if self._value("opacityThreshold", 0.0) > 0.0 else AlphaMode.BLEND
        if not isinstance(texture, tuple):
            color = _rgb(self._value("diffuseColor", (1.0,) * 3 if self.colored else _GREY))
            if not isinstance(alpha, tuple):
                return (*color, alpha), None, mode
            return (*color, 1.0), self._composed([1.0, 1.0, 1.0, alpha], srgb=True), mode
        own_alpha = isinstance(alpha, tuple) and alpha[0].file == texture[0].file and alpha[1] == 3
        if mode is AlphaMode.OPAQUE or own_alpha:
            color, slot = self._shown(texture, 1.0)
            return (*color, 1.0), slot, mode
        channels = [*_color_channels(texture), alpha if isinstance(alpha, tuple) else 1.0]
        return (1.0, 1.0, 1.0, 1.0 if isinstance(alpha, tuple) else alpha), self._composed(channels, srgb=True), mode

    def _color(self, name: str, default: Rgb) -> tuple[Rgb, TextureSlot | None]:
        """The colour at `name` and its texture, which it multiplies."""
        found = self._source(name)
        return self._shown(found, np.inf) if isinstance(found, tuple) else (_rgb(self._value(name, default)), None)

    def _shown(self, found: tuple[UvTexture, int], most: float) -> tuple[Rgb, TextureSlot]:
        """A factor, none of it above `most`, and the slot of a texture that is a colour."""
        texture, channel = found
        scale = texture.scale[:3]
        if channel == _RGB and not texture.bias[:3].any() and (scale >= 0.0).all() and (scale <= most).all():
            return _rgb(scale), self.owner.textures.slot(texture, self._uv_set(texture), texture.encoded is True)
        return (1.0, 1.0, 1.0), self._composed([*_color_channels(found), 1.0], srgb=True)

    def _metallic_roughness(self) -> tuple[float, float, TextureSlot | None]:
        """Metallic, roughness and the texture with both, as glTF has them in blue and green."""
        found = {"roughness": self._source("roughness"), "metallic": self._source("metallic")}
        factors = {"roughness": self._value("roughness", 0.5), "metallic": self._value("metallic", 0.0)}
        textured = {name: source for name, source in found.items() if isinstance(source, tuple)}
        slot = None
        if textured:
            slot = self._composed([1.0, *(textured.get(name, 1.0) for name in found), 1.0], srgb=False)
            factors |= dict.fromkeys(textured, 1.0)
        return _share(factors["metallic"]), _share(factors["roughness"]), slot

    def _normal(self) -> TextureSlot | None:
        found = self._source("normal")
        if not isinstance(found, tuple):
            return None
        texture = found[0]
        if not texture.bias.any():  # as written by who did not know that normals need a scale of 2 and a bias of -1
            return self.owner.textures.slot(texture, self._uv_set(texture), srgb=False)
        halved = replace(texture, scale=texture.scale / 2.0, bias=texture.bias / 2.0 + 0.5)
        if np.allclose(halved.scale[:3], 1.0) and np.allclose(halved.bias[:3], 0.0):
            return self.owner.textures.slot(texture, self._uv_set(texture), srgb=False)
        return self._composed([*((halved, number) for number in range(3)), 1.0], srgb=False)

    def _composed(self, sources: list[Any], srgb: bool) -> TextureSlot:
        first = next(source[0] for source in sources if isinstance(source, tuple))
        return self.owner.textures.composed(sources, self._uv_set(first), srgb)

    def _uv_set(self, texture: UvTexture) -> int:
        if texture.uv_name not in self.uv_names:
            self.uv_names.append(texture.uv_name)
        return self.uv_names.index(texture.uv_name)

    def _source(self, name: str) -> tuple[UvTexture, int] | None:
        """The texture at the input `name` and its channel, or 4 for a colour's three; None where a value counts."""
        textures = self.owner.textures
        found = textures.source(self.shader.GetInput(name))
        if not is_shader(found):
            return None
        shader, output = found
        if str(shader.GetShaderId()).startswith("UsdPrimvarReader"):
            if name in ("diffuseColor", "opacity") and textures.value(shader, "varname", "").startswith("display"):
                self.colored = True
            else:
                self.owner.stage.remarks.add(f"{name} from a primvar is not supported: its default counts")
            return None
        texture = textures.uv_texture(shader)
        if texture is None:
            return None
        if name in ("diffuseColor", "emissiveColor", "specularColor"):
            texture = replace(texture, encoded=texture.encoded is not False)
        return texture, _OUTPUTS.get(output, _RGB)

    def _value(self, name: str, default: Any) -> Any:
        return self.owner.textures.value(self.shader, name, default)


def _color_channels(found: tuple[UvTexture, int]) -> list[tuple[UvTexture, int]]:
    texture, channel = found
    return [(texture, number if channel == _RGB else channel) for number in range(3)]


def _share(value: Any) -> float:
    return min(max(float(value), 0.0), 1.0)


def _rgb(values: Any) -> Rgb:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
