"""Materials of an FBX scene: PBR shaders and Phong, which ufbx converts, as metallic-roughness."""

from dataclasses import dataclass, field
from itertools import chain
from pathlib import PureWindowsPath
from typing import Any

import numpy as np

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.floats import triple
from gpu.scene.formats.fbx.extracted import Extracted, matrix_of
from gpu.scene.formats.files import confined_file, ends_in, read_bytes
from gpu.scene.formats.images import decode_image, fitted
from gpu.scene.transforms import slot_transform
from gpu.scene.types import AlphaMode, Bytes, Material, Rgb, Texture, TextureSlot, Wrap

DEFAULT_MATERIAL = Material("default", (0.8, 0.8, 0.8, 1.0), specular=0.0)
"""What a mesh without a material has: matt grey."""

_TEXTURED = ("base_color", "emission_color", "normal_map")
_ROUGH_METAL = ("roughness", "glossiness", "metalness")  # of PBR shaders; Phong's are exponents and reflections
_MIN_IOR = 1.0


@dataclass
class Materials:
    """The materials that meshes use, each made when first used."""

    found: Extracted
    materials: list[Material] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[int | None, int] = field(default_factory=dict)
    _slots: dict[tuple[int | str | None, ...], TextureSlot | None] = field(default_factory=dict)
    _images: dict[int, Bytes | None] = field(default_factory=dict)

    def number(self, wanted: int | None) -> int:
        """The number in `materials` of the file's material `wanted`; None stands for the default one."""
        if wanted not in self._numbers:
            made = DEFAULT_MATERIAL if wanted is None else self._made(self.found.told["materials"][wanted])
            self.materials.append(made)
            self._numbers[wanted] = len(self.materials) - 1
        return self._numbers[wanted]

    def _made(self, told: dict[str, Any]) -> Material:
        shown = _TEXTURED if told["classic"] else (*_TEXTURED, *_ROUGH_METAL)
        for name, entry in told.items():
            if isinstance(entry, dict) and entry["texture"] is not None and name not in shown:
                self.found.remarks.add(f"textures of {name.replace('_', ' ')} are not shown", told["name"])
        base, emission = self._slot(told, "base_color", True), self._slot(told, "emission_color", True)
        rough, metal, surface = (False, False, None) if told["classic"] else self._rough_metal(told)
        through = _value(told, "transmission_factor", (0.0,))[0]
        if told["classic"]:  # where it is a share that lets all light pass, not glass
            covered = 1.0 - through * float(np.mean(_value(told, "transmission_color", (1.0,) * 4)[:3]))
            through = 0.0
        else:
            covered = 1.0
        opacity = float(np.clip(_value(told, "opacity", (covered,))[0], 0.0, 1.0))
        color = np.clip(_color(told, "base", (0.8, 0.8, 0.8)), 0.0, 1.0) if base is None else np.ones(3)
        glow = np.maximum(_color(told, "emission", (0.0, 0.0, 0.0)), 0.0)
        if emission is not None and not glow.any():
            glow = np.ones(3)
        specular = _value(told, "specular_factor", (1.0,))[0] * max(_value(told, "specular_color", (1.0,) * 4)[:3])
        return Material(
            name=told["name"],
            base_color=(*triple(color), opacity),
            metallic=1.0 if metal else float(np.clip(_value(told, "metalness", (0.0,))[0], 0.0, 1.0)),
            roughness=1.0 if rough else float(np.clip(_value(told, "roughness", (1.0,))[0], 0.0, 1.0)),
            emission=triple(glow),
            base_color_slot=base,
            metallic_roughness_slot=surface,
            emission_slot=emission,
            normal_slot=self._slot(told, "normal_map", False),
            alpha_mode=AlphaMode.BLEND if opacity < 1.0 else AlphaMode.OPAQUE,
            double_sided=True if told["double_sided"] else None,  # most programs never say so
            transmission=float(np.clip(through, 0.0, 1.0)),
            ior=max(_value(told, "specular_ior", (1.5,))[0], _MIN_IOR),
            specular=float(specular > 0.0),
        )

    def _slot(self, told: dict[str, Any], name: str, srgb: bool) -> TextureSlot | None:
        number = told[name]["texture"]
        if number is None:
            return None
        if (number, srgb) not in self._slots:
            pixels = self._image(number)
            self._slots[number, srgb] = None if pixels is None else self._texture(number, pixels, srgb)
        return self._slots[number, srgb]

    def _rough_metal(self, told: dict[str, Any]) -> tuple[bool, bool, TextureSlot | None]:
        """Whether roughness and metalness have textures, and both as one: green and blue (glTF 2.0, 3.9.2).

        It lies as that of roughness; each is the red of its own, and glossiness is 1 − roughness.
        """
        gloss = told["roughness"]["texture"] is None
        rough = told["glossiness" if gloss else "roughness"]["texture"]
        metal = told["metalness"]["texture"]
        images = [None if number is None else self._image(number) for number in (rough, metal)]
        laid = next((image for image in images if image is not None), None)
        if laid is None:
            return False, False, None
        has = images[0] is not None, images[1] is not None
        key = ("rough metal", rough if has[0] else None, metal if has[1] else None, int(gloss))
        if key not in self._slots:
            pixels = np.full_like(laid, 255)
            for channel, image in ((1, images[0]), (2, images[1])):
                if image is not None:
                    red = fitted(image[:, :, 0], pixels)
                    pixels[:, :, channel] = 255 - red if gloss and channel == 1 else red
            self._slots[key] = self._texture(rough if has[0] else metal, pixels, srgb=False)
        return *has, self._slots[key]

    def _image(self, number: int) -> Bytes | None:
        """The pixels of a texture; None, and said, when it has no image that can be read."""
        if number not in self._images:
            self._images[number] = self._decoded(number)
        return self._images[number]

    def _decoded(self, number: int) -> Bytes | None:
        told, remarks = self.found.told["textures"][number], self.found.remarks
        name = PureWindowsPath(told["names"][0] or told["names"][1]).name
        content = self._content(number, told["names"])
        if not told["file"] or content is None:
            remarks.add("the texture's file is missing" if told["file"] else "layered textures are not shown", name)
            return None
        try:
            return decode_image(content, str(self.found.path), name, self.found.limits)
        except ForbiddenError:
            raise
        except SceneError as error:
            remarks.add(f"{error.problem}; it was left out", name)
            return None

    def _texture(self, number: int, pixels: Bytes, srgb: bool) -> TextureSlot:
        """A new texture of `pixels`, called, wrapped and laid as the file's texture `number`."""
        told = self.found.told["textures"][number]
        name = PureWindowsPath(told["names"][0] or told["names"][1]).name
        wraps = [Wrap.CLAMP if clamped else Wrap.REPEAT for clamped in told["clamped"]]
        self.textures.append(Texture(name, pixels, srgb, wraps[0], wraps[1]))
        placed = matrix_of(told["transform"])
        return TextureSlot(len(self.textures) - 1, 0, slot_transform(placed[np.ix_([0, 1, 3], [0, 1, 3])]))

    def _content(self, number: int, names: list[str]) -> bytes | None:
        """The bytes that are embedded, or those of the file by its relative path or beside the scene.

        Exporters write the absolute path on their own machine, of which the end may be there.
        """
        embedded = self.found.arrays[f"texture{number}"]
        if embedded.size:
            return embedded.tobytes()
        ends = chain.from_iterable(ends_in(self.found.path.parent, name) for name in names)
        for name in (*names, *ends):
            path = PureWindowsPath(name)
            if name and not path.is_absolute() and not path.root and ".." not in path.parts:
                file = confined_file(self.found.path, path.as_posix(), name)
                if file is not None:
                    return read_bytes(file, self.found.limits)
        return None


def _value(told: dict[str, Any], name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    value = told[name]["value"]
    return default if value is None else tuple(value)


def _color(told: dict[str, Any], kind: str, default: Rgb) -> Any:
    """A colour times its factor."""
    return np.array(_value(told, f"{kind}_color", default)[:3]) * _value(told, f"{kind}_factor", (1.0,))[0]
