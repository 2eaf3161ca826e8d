"""Materials of an FBX scene: PBR shaders and Phong, which ufbx converts, as metallic-roughness."""

from dataclasses import dataclass, field
from pathlib import PureWindowsPath
from typing import Any

import numpy as np

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.fbx.extracted import Extracted, matrix_of
from gpu.scene.files import confined_file, read_bytes
from gpu.scene.images import decode_image
from gpu.scene.types import AlphaMode, Material, Rgb, Texture, TextureSlot, Wrap

DEFAULT_MATERIAL = Material("default", (0.8, 0.8, 0.8, 1.0), specular=0.0)
"""What a mesh without a material has: matt grey."""

_TEXTURED = ("base_color", "emission_color", "normal_map")
_FLIP = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])  # v to 1 − v
_MIN_IOR = 1.0


@dataclass
class Materials:
    """The materials that meshes use, each made when first used."""

    found: Extracted
    materials: list[Material] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[int | None, int] = field(default_factory=dict)
    _slots: dict[tuple[int, bool], TextureSlot | None] = field(default_factory=dict)

    def number(self, wanted: int | None) -> int:
        """The number in `materials` of the file's material `wanted`; None stands for the default one."""
        if wanted not in self._numbers:
            made = DEFAULT_MATERIAL if wanted is None else self._made(self.found.told["materials"][wanted])
            self.materials.append(made)
            self._numbers[wanted] = len(self.materials) - 1
        return self._numbers[wanted]

    def _made(self, told: dict[str, Any]) -> Material:
        for name, entry in told.items():
            if isinstance(entry, dict) and entry["texture"] is not None and name not in _TEXTURED:
                self.found.remarks.add(f"textures of {name.replace('_', ' ')} are not shown", told["name"])
        base, emission = self._slot(told, "base_color", True), self._slot(told, "emission_color", True)
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
            base_color=(*_rgb(color), opacity),
            metallic=float(np.clip(_value(told, "metalness", (0.0,))[0], 0.0, 1.0)),
            roughness=float(np.clip(_value(told, "roughness", (1.0,))[0], 0.0, 1.0)),
            emission=_rgb(glow),
            base_color_slot=base,
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
            self._slots[number, srgb] = self._texture(number, srgb)
        return self._slots[number, srgb]

    def _texture(self, number: int, srgb: bool) -> TextureSlot | None:
        """The slot of a texture; None, and said, when it has no image that can be read."""
        told, remarks = self.found.told["textures"][number], self.found.remarks
        name = PureWindowsPath(told["names"][0] or told["names"][1]).name
        content = self._content(number, told["names"])
        if not told["file"] or content is None:
            remarks.add("the texture's file is missing" if told["file"] else "layered textures are not shown", name)
            return None
        try:
            pixels = decode_image(content, str(self.found.path), name, self.found.limits)
        except ForbiddenError:
            raise
        except SceneError as error:
            remarks.add(f"{error.problem}; it was left out", name)
            return None
        wraps = [Wrap.CLAMP if clamped else Wrap.REPEAT for clamped in told["clamped"]]
        self.textures.append(Texture(name, pixels, srgb, wraps[0], wraps[1]))
        placed = matrix_of(told["transform"])
        matrix = _FLIP @ placed[np.ix_([0, 1, 3], [0, 1, 3])] @ _FLIP
        a, b, c, d, e, f = (float(value) for value in matrix[:2].reshape(-1))
        return TextureSlot(len(self.textures) - 1, 0, (a, b, c, d, e, f))

    def _content(self, number: int, names: list[str]) -> bytes | None:
        """The bytes that are embedded, or those of the file by its relative path or beside the scene.

        Exporters write the absolute path on their own machine; of that the last part counts.
        """
        embedded = self.found.arrays[f"texture{number}"]
        if embedded.size:
            return embedded.tobytes()
        for name in (*names, *(PureWindowsPath(name).name for name in names)):
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


def _rgb(values: Any) -> Rgb:
    return (float(values[0]), float(values[1]), float(values[2]))
