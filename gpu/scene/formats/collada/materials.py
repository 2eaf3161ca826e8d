"""Effects of COLLADA's common profile as metallic-roughness; colours are as on a display."""

from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.colors import srgb_to_linear
from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.collada.effects import Effect, Sampler
from gpu.scene.formats.images import decode_image
from gpu.scene.formats.mtl import DEFAULT_MATERIAL, phong_roughness
from gpu.scene.formats.xml_tree import text_of
from gpu.scene.types import AlphaMode, Bytes, Doubles, Material, Rgb, Texture, TextureSlot


@dataclass(frozen=True, order=True)
class Binding:
    """What an instance gives a material symbol: a material, and the UV set of each name of texture coordinates."""

    material: str
    uv_sets: tuple[tuple[str, int], ...] = ()

    def uv_set(self, name: str) -> int:
        """The UV set that an effect calls `name`; the first where nothing says."""
        return dict(self.uv_sets).get(name, 0)


def bindings_of(document: Document, instance: Element) -> dict[str, Binding]:
    """The bindings of an instance's material symbols."""
    found = {}
    for bound in instance.findall("bind_material/technique_common/instance_material"):
        uv_sets = []
        for given in bound.findall("bind_vertex_input"):
            number = given.get("input_set", "0").strip()
            if number.isdecimal():
                uv_sets.append((given.get("semantic", ""), int(number)))
            else:
                document.remarks.add("the set of texture coordinates is no number: the first was taken", number[:20])
        found[bound.get("symbol", "")] = Binding(bound.get("target", ""), tuple(uv_sets))
    return found


@dataclass
class Materials:
    """The materials that geometries use, each made when first used."""

    document: Document
    materials: list[Material] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[Binding | None, tuple[int, tuple[int, ...]]] = field(default_factory=dict)
    _textures: dict[tuple[object, ...], int | None] = field(default_factory=dict)
    _pixels: dict[Element, Bytes | None] = field(default_factory=dict)

    def number(self, binding: Binding | None, symbol: str) -> tuple[int, tuple[int, ...]]:
        """The number in `materials` of what is bound, grey for None, and which of the file's UV sets are its own."""
        if binding is None and symbol:
            self.document.remarks.add("a material that nothing is bound to: its surfaces are grey", repr(symbol))
        if binding not in self._numbers:
            uv_sets: list[int] = []
            self.materials.append(DEFAULT_MATERIAL if binding is None else self._made(binding, uv_sets))
            self._numbers[binding] = len(self.materials) - 1, tuple(uv_sets or [0])
        return self._numbers[binding]

    def _made(self, binding: Binding, uv_sets: list[int]) -> Material:
        found = self.document.find(binding.material, "material")
        said = None if found is None else found.find("instance_effect")
        effect = None if said is None else self.document.find(said.get("url"), "effect")
        if found is None or effect is None:
            return DEFAULT_MATERIAL
        name = found.get("name") or found.get("id") or ""
        return self._of_effect(Effect(self.document, effect, name), binding, uv_sets)

    def _of_effect(self, effect: Effect, binding: Binding, uv_sets: list[int]) -> Material:
        remarks = self.document.remarks
        base_map = effect.sampler("diffuse")
        opacity, mask = effect.opacity()
        cut_out = mask is not None and base_map is not None and mask.image is base_map.image
        if mask is not None and not cut_out:
            remarks.add("textures of transparency are only shown where the colour has the same", effect.name)
        base = self._slot(base_map, binding, uv_sets, srgb=True)
        glow = self._slot(effect.sampler("emission"), binding, uv_sets, srgb=True)
        constant = effect.shader == "constant"
        color = effect.color("diffuse", effect.color("emission", (0.8, 0.8, 0.8)) if constant else (0.8, 0.8, 0.8))
        emission = (1.0, 1.0, 1.0) if glow else effect.color("emission", (0.0, 0.0, 0.0))
        specular = max(effect.color("specular", (0.0, 0.0, 0.0))) if effect.shader in ("phong", "blinn") else 0.0
        ior = effect.number("index_of_refraction", 1.5)
        effect.say_unread()
        return Material(
            name=effect.name,
            base_color=(*((1.0, 1.0, 1.0) if base else np.minimum(_linear(color), 1.0).tolist()), opacity),
            roughness=phong_roughness(max(effect.number("shininess", 0.0), 0.0)) if specular > 0.0 else 1.0,
            specular=float(specular > 0.0),
            emission=(0.0, 0.0, 0.0) if constant else _linear(emission),
            unlit=constant,
            base_color_slot=base,
            emission_slot=None if constant else glow,
            normal_slot=self._slot(effect.normal_map(), binding, uv_sets, srgb=False),
            alpha_mode=AlphaMode.BLEND if opacity < 1.0 or (base and cut_out) else AlphaMode.OPAQUE,
            double_sided=True if effect.double_sided else None,  # most programs never say so
            ior=ior if ior > 1.0 else 1.5,  # 1 is what programs write that know no index of refraction
        )

    def _slot(self, sampler: Sampler | None, binding: Binding, uv_sets: list[int], srgb: bool) -> TextureSlot | None:
        if sampler is None:
            return None
        key = (sampler.image, sampler.wrap_s, sampler.wrap_t, srgb)
        if key not in self._textures:
            self._textures[key] = self._texture(sampler, srgb)
        number = self._textures[key]
        if number is None:
            return None
        wanted = binding.uv_set(sampler.texcoord)
        if wanted not in uv_sets:
            uv_sets.append(wanted)
        return TextureSlot(number, uv_sets.index(wanted))

    def _texture(self, sampler: Sampler, srgb: bool) -> int | None:
        """The number of a texture; None, and said, where its image cannot be read."""
        name = sampler.image.get("name") or sampler.image.get("id") or "image"
        pixels = self._image(sampler.image, name)
        if pixels is None:
            return None
        self.textures.append(Texture(name, pixels, srgb, sampler.wrap_s, sampler.wrap_t))
        return len(self.textures) - 1

    def _image(self, image: Element, name: str) -> Bytes | None:
        if image not in self._pixels:
            self._pixels[image] = self._decoded(image, f"image {name}")
        return self._pixels[image]

    def _decoded(self, image: Element, place: str) -> Bytes | None:
        document, data = self.document, image.find("data")
        if data is None:
            data = image.find("init_from/hex")
        uri = text_of(image.find("init_from/ref")) or text_of(image.find("init_from"))
        try:
            content = bytes.fromhex(text_of(data)) if data is not None else document.content(uri, place)
            return decode_image(content, str(document.path), place, document.limits)
        except ForbiddenError:
            raise
        except (SceneError, ValueError) as error:
            problem = error.problem if isinstance(error, SceneError) else f"broken data: {error}"
            document.remarks.add(f"the texture was left out: {problem}", place)
            return None


def _linear(color: Rgb) -> Rgb:
    """A colour as displays show it, linear; above 1, as emission can be, it counts as it is."""
    values: Doubles = np.array(color)
    red, green, blue = np.where(values <= 1.0, srgb_to_linear(np.minimum(values, 1.0) * 255.0), values)
    return (float(red), float(green), float(blue))
