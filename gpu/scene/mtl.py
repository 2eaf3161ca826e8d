"""MTL material libraries, as OBJ files name them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from gpu.errors import SceneError
from gpu.scene.files import confined_file, read_bytes
from gpu.scene.images import decode_image
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Material, Rgb, Texture, TextureSlot

DEFAULT_MATERIAL = Material(name="default", base_color=(0.8, 0.8, 0.8, 1.0), specular=0.0)
"""What a surface has that names no material: matt grey."""

_UNUSED = ("d", "tr", "tf", "map_d", "map_ks", "map_ns", "map_bump", "bump", "norm", "disp", "refl", "map_pr", "map_pm")


class MaterialLibrary:
    """The materials that an OBJ file's libraries define, with their textures, and sentences on what was ignored."""

    def __init__(self, scene: Path, limits: SceneLimits) -> None:
        self.materials: dict[str, Material] = {}
        self.textures: list[Texture] = []
        self.ignored: dict[str, None] = {}
        self._scene, self._limits = scene, limits
        self._numbers: dict[Path, int] = {}

    def read(self, name: str) -> None:
        """Add the materials of the library `name`; a missing one is said. Raises SceneError when it is broken."""
        path = confined_file(self._scene, name, "mtllib")
        if path is None:
            self.ignored[f"material library {name} is missing: its surfaces are grey"] = None
            return
        material: Material | None = None
        for number, line in enumerate(read_bytes(path, self._limits).decode("utf-8", "replace").splitlines(), 1):
            key, _, value = line.strip().partition(" ")
            if key == "newmtl":
                material = replace(DEFAULT_MATERIAL, name=value.strip())
            elif material and value and not key.startswith("#"):
                material = self._changed(material, key.lower(), value.strip(), f"{name}: line {number}")
            if material:
                self.materials[material.name] = material

    def _changed(self, material: Material, key: str, value: str, field: str) -> Material:
        """`material` with what one line says."""
        if key == "kd":
            return replace(material, base_color=(*self._rgb(value, field), 1.0))
        if key == "ke":
            return replace(material, emission=self._rgb(value, field))
        if key == "ks":
            return replace(material, specular=float(max(self._rgb(value, field)) > 0.0))
        if key == "ns":  # Phong's exponent n is like a microfacet width with α² = 2 / (n + 2); glTF's α is roughness²
            return replace(material, roughness=(2.0 / (self._numbers_in(value, field)[0] + 2.0)) ** 0.25)
        if key == "map_kd":
            slot = self._slot(value, field)
            # With a texture, exporters write any Kd: the texture alone is the colour.
            return replace(material, base_color_slot=slot, base_color=(1.0, 1.0, 1.0, 1.0)) if slot else material
        if key == "map_ke":
            slot = self._slot(value, field)
            emission = material.emission if any(material.emission) else (1.0, 1.0, 1.0)
            return replace(material, emission_slot=slot, emission=emission) if slot else material
        if key in _UNUSED:
            self.ignored[f"{key} of MTL materials is not supported and was ignored"] = None
        return material

    def _numbers_in(self, value: str, field: str) -> list[float]:
        try:
            numbers = [float(word) for word in value.split()]
        except ValueError:
            numbers = []
        if not numbers or not np.isfinite(numbers).all() or min(numbers) < 0.0:
            raise SceneError(str(self._scene), field, f"must be numbers of at least 0, not {value!r:.60}")
        return numbers

    def _rgb(self, value: str, field: str) -> Rgb:
        numbers = self._numbers_in(value, field)
        if len(numbers) not in (1, 3):
            raise SceneError(str(self._scene), field, f"must be 1 or 3 numbers, not {value!r:.60}")
        return (numbers[0], numbers[-2] if len(numbers) == 3 else numbers[0], numbers[-1])

    def _slot(self, value: str, field: str) -> TextureSlot | None:
        """The texture of a map statement; None, and said, when its file is missing."""
        name = value
        if value.startswith("-"):
            name = value.split()[-1]
            self.ignored["options of MTL textures are not supported and were ignored"] = None
        path = confined_file(self._scene, name, field)
        if path is None:
            self.ignored[f"texture {name} is missing"] = None
            return None
        if path not in self._numbers:
            content = read_bytes(path, self._limits)
            pixels = decode_image(content, str(self._scene), f"{field}: {name}", self._limits)
            self.textures.append(Texture(path.name, pixels, srgb=True))
            self._numbers[path] = len(self.textures) - 1
        return TextureSlot(self._numbers[path])
