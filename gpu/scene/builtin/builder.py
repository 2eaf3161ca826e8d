"""Collects the shapes of a built-in scene by material and assembles them into a Scene."""

from collections.abc import Sequence

from gpu.scene.assemble import MeshPart, assemble
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.textures import LEAST_ALBEDO, MOST_ALBEDO, linear
from gpu.scene.types import Bytes, Camera, Light, Material, Rgb, Scene, Sky, Texture, TextureSlot


class Builder:
    """A scene under construction, in metres."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._materials: list[Material] = []
        self._textures: list[Texture] = []
        self._shapes: list[list[Shape]] = []

    def paint(self, name: str, colour: str, roughness: float = 0.6) -> int:
        """A new material of one sRGB colour "#rrggbb", kept within the albedos of textures; returns its number."""
        r, g, b = (min(max(channel, LEAST_ALBEDO), MOST_ALBEDO) for channel in linear(colour))
        return self.diffuse(name, (r, g, b), roughness)

    def diffuse(self, name: str, albedo: Rgb, roughness: float = 1.0) -> int:
        """A new material of one linear Rec. 709 albedo; returns its number."""
        return self._material(Material(name, base_color=(*albedo, 1.0), roughness=roughness))

    def light(self, name: str, radiance: Rgb) -> int:
        """A new material that emits `radiance` [W/m²/sr] from its front; returns its number."""
        return self._material(Material(name, base_color=(0.6, 0.6, 0.6, 1.0), emission=radiance))

    def textured(
        self, name: str, pixels: Bytes, metres: tuple[float, float] = (1.0, 1.0), roughness: float = 0.6
    ) -> int:
        """A new material that shows `pixels`, one repeat of which covers `metres` (along u, along v); its number."""
        self._textures.append(Texture(name, pixels, srgb=True))
        slot = TextureSlot(len(self._textures) - 1, 0, (1.0 / metres[0], 0.0, 0.0, 0.0, 1.0 / metres[1], 0.0))
        return self._material(Material(name, base_color_slot=slot, roughness=roughness))

    def _material(self, material: Material) -> int:
        self._materials.append(material)
        self._shapes.append([])
        return len(self._materials) - 1

    def add(self, material: int, *shapes: Shape) -> None:
        """Put `shapes` into the scene."""
        self._shapes[material].extend(shapes)

    def scene(self, cameras: Sequence[Camera], lights: Sequence[Light] = (), sky: Sky | None = None) -> Scene:
        """The finished scene."""
        parts = []
        for number, (material, shapes) in enumerate(zip(self._materials, self._shapes, strict=True)):
            whole = join(shapes)
            parts.append(
                MeshPart(
                    whole.positions, whole.triangles, whole.normals, (whole.uvs,), material=number, name=material.name
                )
            )
        return assemble(self._name, parts, self._materials, self._textures, lights, cameras, sky)
