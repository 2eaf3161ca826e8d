"""Lights of UsdLux: those with a surface as emissive surfaces, distant ones as directional, a dome as the sky."""

from dataclasses import dataclass, field, replace
from math import pi, radians, sin
from typing import Any

import numpy as np
from pxr import UsdLux

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.colors import srgb_to_linear
from gpu.scene.floats import triple
from gpu.scene.formats.images import decode_image
from gpu.scene.formats.usd.hierarchy import PlacedPrim
from gpu.scene.formats.usd.materials import Materials
from gpu.scene.formats.usd.shapes import arc, disc, rectangle, revolved, tube, turned
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import placed, rigid
from gpu.scene.types import Doubles, Light, LightKind, Material, Sky

# A level floor gets 5/6 of π·radiance from a Sky, and π·radiance from a dome.
_SKY_OF_DOME = 6.0 / 5.0
_BACK = np.diag([1.0, -1.0, -1.0, 1.0])  # lights shine along −Z


@dataclass
class Lights:
    """The lights that were read. metres: of a unit of the file, which intensities [W/sr] need."""

    materials: Materials
    metres: float
    parts: list[MeshPart] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    sky: Sky | None = None

    def read(self, light: PlacedPrim) -> None:
        """Add the light at the prim; one of a kind that is not shown is said. Raises SceneError."""
        prim, stage = light.prim, self.materials.stage
        if prim.HasAPI(UsdLux.ShapingAPI):
            self._say_shaping(prim)
        if prim.IsA(UsdLux.DistantLight):
            self._distant(light)
        elif prim.IsA(UsdLux.DomeLight) or prim.IsA(UsdLux.DomeLight_1):
            self._dome(prim)
        elif prim.IsA(UsdLux.SphereLight) and self._number(prim, "treatAsPoint", 0.0):
            self._point(light)
        elif prim.IsA(UsdLux.RectLight):
            radiance = self._radiance(prim)
            if self._asset(prim) is not None:
                radiance = radiance * self._mean_of_texture(prim)
            self._surface(light, rectangle(self._number(prim, "width"), self._number(prim, "height")), radiance)
        elif prim.IsA(UsdLux.DiskLight):
            shape = revolved([disc(self._number(prim, "radius"), 0.0, 1.0)])
            self._surface(light, shape, self._radiance(prim))
        elif prim.IsA(UsdLux.SphereLight):
            self._surface(light, revolved([arc(self._number(prim, "radius"))]), self._radiance(prim), around=True)
        elif prim.IsA(UsdLux.CylinderLight):
            outline = tube(self._number(prim, "radius"), self._number(prim, "length") / 2.0)
            self._surface(light, turned(revolved([outline]), "X"), self._radiance(prim), around=True)
        else:
            stage.remarks.add(f"lights of kind {prim.GetTypeName()} are not shown", str(prim.GetPath()))

    def _surface(self, light: PlacedPrim, shape: MeshPart, radiance: Doubles, around: bool = False) -> None:
        """An emissive surface, black otherwise. around: it shines to all sides, not along −Z alone."""
        normalised = bool(self._number(light.prim, "normalize", 0.0))
        name = str(light.prim.GetPath())
        for matrix in light.to_world:
            part = placed(shape, matrix[None] if around else (matrix @ _BACK)[None])
            area = np.linalg.norm(area_vectors(part.positions, part.triangles), axis=1).sum() / 2.0
            emission = radiance / area if normalised and area > 0.0 else radiance
            number = self.materials.add(
                Material(name, (0.0, 0.0, 0.0, 1.0), emission=triple(emission), specular=0.0, roughness=1.0)
            )
            self.parts.append(replace(part, material=number, name=name))

    def _point(self, light: PlacedPrim) -> None:
        """A sphere seen from afar: intensity = radiance · π r² (r² in m²)."""
        radius = self._number(light.prim, "radius")
        for matrix in light.to_world:
            scale = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
            disc_area = pi * (radius * scale) ** 2
            if self._number(light.prim, "normalize", 0.0):
                disc_area = 0.25
            intensity = self._radiance(light.prim) * disc_area * self.metres**2
            position = triple(matrix[:3, 3])
            self.lights.append(Light(light.prim.GetName(), LightKind.POINT, triple(intensity), position))

    def _distant(self, light: PlacedPrim) -> None:
        """Irradiance = radiance · π sin²(half angle), or the radiance itself where it is normalised or has no angle."""
        half = radians(min(self._number(light.prim, "angle"), 180.0)) / 2.0
        normalised = bool(self._number(light.prim, "normalize", 0.0))
        irradiance = self._radiance(light.prim) * (1.0 if normalised or half == 0.0 else pi * sin(half) ** 2)
        for matrix in light.to_world:
            direction = triple(-rigid(matrix)[:3, 2])
            name = light.prim.GetName()
            self.lights.append(Light(name, LightKind.DIRECTIONAL, triple(irradiance), direction=direction))

    def _dome(self, prim: Any) -> None:
        stage, radiance = self.materials.stage, self._radiance(prim) * _SKY_OF_DOME
        if self._asset(prim) is not None:
            radiance = radiance * self._mean_of_texture(prim)
        stage.remarks.add("a dome light is shown as a sky that is brightest above and black below", str(prim.GetPath()))
        self.sky = Sky(triple(radiance + (self.sky.radiance if self.sky else 0.0)))

    def _asset(self, prim: Any) -> Any:
        attribute = prim.GetAttribute("inputs:texture:file")
        value = attribute.Get(self.materials.stage.time) if attribute else None
        return attribute if value is not None and value.path else None

    def _mean_of_texture(self, prim: Any) -> Doubles:
        """The mean colour (3,) of a light's texture; white, and said, where it cannot be read."""
        stage = self.materials.stage
        found = stage.content(self._asset(prim))
        if found is None:
            return np.ones(3)
        try:
            pixels = decode_image(found[1], str(stage.path), str(prim.GetPath()), stage.limits)
        except ForbiddenError:
            raise
        except SceneError:
            stage.remarks.add("a light's texture cannot be read, its colour alone counts", str(prim.GetPath()))
            return np.ones(3)
        stage.remarks.add("the mean of a light's texture counts, not its picture", str(prim.GetPath()))
        latitude = (np.arange(len(pixels)) + 0.5) / len(pixels) * pi
        weights = np.ones(len(pixels)) if prim.IsA(UsdLux.RectLight) else np.sin(latitude)
        rows = srgb_to_linear(pixels[..., :3]).mean(axis=1)
        return np.asarray((rows * weights[:, None]).sum(axis=0) / weights.sum())

    def _radiance(self, prim: Any) -> Doubles:
        """Intensity · 2^exposure · colour, as the light has it before it is normalised."""
        number = self._number
        color = np.array(prim.GetAttribute("inputs:color").Get(self.materials.stage.time), np.float64)
        if number(prim, "enableColorTemperature", 0.0):
            color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(number(prim, "colorTemperature")))
        for name in ("diffuse", "specular"):
            if number(prim, name, 1.0) != 1.0:
                self.materials.stage.remarks.add(f"the {name} multiplier of lights is not shown", str(prim.GetPath()))
        return np.maximum(number(prim, "intensity") * 2.0 ** number(prim, "exposure", 0.0) * color, 0.0)

    def _number(self, prim: Any, name: str, otherwise: float = 0.0) -> float:
        attribute = prim.GetAttribute(name if name == "treatAsPoint" else f"inputs:{name}")
        value = attribute.Get(self.materials.stage.time) if attribute else None
        return float(otherwise if value is None else value)

    def _say_shaping(self, prim: Any) -> None:
        shaping, time = UsdLux.ShapingAPI(prim), self.materials.stage.time
        ies = shaping.GetShapingIesFileAttr().Get(time)
        cone = self._number(prim, "shaping:cone:angle", 90.0) < 90.0
        if cone or self._number(prim, "shaping:focus", 0.0) or (ies is not None and ies.path):
            self.materials.stage.remarks.add(
                "cones, focus and IES profiles of lights are not shown", str(prim.GetPath())
            )
