"""One effect of COLLADA's common profile: its shader's colours, numbers and samplers, through its parameters."""

from dataclasses import dataclass
from functools import cached_property
from xml.etree.ElementTree import Element

import numpy as np

from gpu.scene.formats.collada.document import Document
from gpu.scene.formats.xml_tree import number_row, text_of
from gpu.scene.types import Rgb, Wrap

_SHADERS = ("phong", "blinn", "lambert", "constant")
_WRAPS = {"MIRROR": Wrap.MIRROR, "CLAMP": Wrap.CLAMP, "BORDER": Wrap.CLAMP, "NONE": Wrap.CLAMP}
_LUMINANCE = np.array([0.212671, 0.715160, 0.072169])  # COLLADA 1.4.1, page 7-5
_TEXTURED = ("diffuse", "emission", "transparent")


@dataclass(frozen=True)
class Sampler:
    """One use of an image. texcoord: what the effect calls its texture coordinates."""

    image: Element
    texcoord: str
    wrap_s: Wrap = Wrap.REPEAT
    wrap_t: Wrap = Wrap.REPEAT


class Effect:
    """What `element` says. name: of the material, for the report."""

    def __init__(self, document: Document, element: Element, name: str) -> None:
        self.name = name
        self._document, self._element = document, element
        profile = element.find("profile_COMMON")
        technique = None if profile is None else profile.find("technique")
        found = [] if technique is None else [shader for shader in technique if shader.tag in _SHADERS]
        if not found:
            document.remarks.add("an effect without a common profile: its surfaces are grey", name)
        self._shader = found[0] if found else Element("lambert")
        self.shader = self._shader.tag

    @cached_property
    def _params(self) -> dict[str, Element]:
        return {param.get("sid", ""): param for param in self._element.iter("newparam")}

    def color(self, key: str, default: Rgb) -> Rgb:
        """The colour `key`, as in the file; `default` where it has none."""
        values = self._values(key, "color")
        if values is None or len(values) < 3:
            return default
        return (float(values[0]), float(values[1]), float(values[2]))

    def number(self, key: str, default: float) -> float:
        """The number `key`; `default` where there is none."""
        values = self._values(key, "float")
        return float(values[0]) if values is not None and len(values) else default

    def sampler(self, key: str) -> Sampler | None:
        """The texture that the shader has as `key`; None, and said, where its image is not in the file."""
        return self._sampler(self._shader.find(f"{key}/texture"))

    def normal_map(self) -> Sampler | None:
        """The normal map that programs write as an extra; other bump maps are said."""
        for bump in self._element.iter("bump"):
            if bump.get("bumptype") == "NORMALMAP":
                return self._sampler(bump.find("texture"))
            self._document.remarks.add("bump maps are not shown", self.name)
        return None

    def opacity(self) -> tuple[float, Sampler | None]:
        """Opacity 0–1 (COLLADA 1.4.1, page 7-5), and the texture that it is multiplied with."""
        said = self._shader.find("transparent")
        factor = self.number("transparency", 1.0)
        if said is None:
            opacity = factor
        else:
            values = self._values("transparent", "color")
            rgba = np.ones(4) if values is None or len(values) < 3 else np.append(values, 1.0)[:4]
            mode = said.get("opaque", "A_ONE")
            share = float(rgba[:3] @ _LUMINANCE) if mode.startswith("RGB") else float(rgba[3])
            opacity = 1.0 - share * factor if mode.endswith("ZERO") else share * factor
        if opacity <= 0.0:
            self._document.remarks.add("a material that is not seen at all was taken as opaque", self.name)
            opacity = 1.0
        return min(opacity, 1.0), self._sampler(None if said is None else said.find("texture"))

    @property
    def double_sided(self) -> bool:
        """Whether a program's extra says that both sides are alike."""
        return any(text_of(said) in ("1", "true") for said in self._element.iter("double_sided"))

    def say_unread(self) -> None:
        """Say which textures and reflections are not shown."""
        for said in self._shader:
            if said.find("texture") is not None and said.tag not in _TEXTURED:
                self._document.remarks.add(f"textures of {said.tag} are not shown", self.name)
        if self.number("reflectivity", 0.0) > 0.0 and max(self.color("reflective", (0.0, 0.0, 0.0))) > 0.0:
            self._document.remarks.add("reflectivity is not shown", self.name)

    def _values(self, key: str, kind: str) -> np.ndarray | None:
        """Finite numbers of the shader's `key`, a color or a float, its own or a parameter's; None, and said, else."""
        said = self._shader.find(key)
        if said is None:
            return None
        value = said.find(kind)
        reference = said.find("param")
        if value is None and reference is not None:
            param = self._params.get(reference.get("ref", ""))
            value = None if param is None else next((each for each in param if each.tag.startswith("float")), None)
        if value is None:
            return None
        try:
            values = number_row(text_of(value))
        except ValueError:
            values = np.array([np.nan])
        if not np.isfinite(values).all():
            self._document.remarks.add(f"{key} is no number and was ignored", self.name)
            return None
        return np.maximum(values, 0.0)

    def _sampler(self, texture: Element | None) -> Sampler | None:
        """What a <texture> names: a sampler's parameter, or, as some programs write, an image."""
        if texture is None:
            return None
        name, wraps = texture.get("texture", ""), [Wrap.REPEAT, Wrap.REPEAT]
        param = self._params.get(name)
        sampler = None if param is None else param.find("sampler2D")
        if sampler is not None:
            wraps = [_WRAPS.get(text_of(sampler.find(key)), Wrap.REPEAT) for key in ("wrap_s", "wrap_t")]
            instance = sampler.find("instance_image")
            surface = self._params.get(text_of(sampler.find("source")))
            init = None if surface is None else surface.find("surface/init_from")
            name = text_of(init) if instance is None else instance.get("url", "")
        image = self._document.find(name, "image")
        if texture.find("extra") is not None:
            self._document.remarks.add("programs' own placement of textures is not used", self.name)
        return None if image is None else Sampler(image, texture.get("texcoord", ""), wraps[0], wraps[1])
