"""MTL material libraries, as OBJ files name them, as materials of the renderer."""

import re
from dataclasses import replace
from pathlib import Path

from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.mtl.maps import MapFiles, MapImage, is_normal_map
from gpu.scene.formats.mtl.statements import MtlMaterial, read_materials
from gpu.scene.formats.text import decoded, uncommented
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.types import AlphaMode, Material, Texture

DEFAULT_MATERIAL = Material(name="default", base_color=(0.8, 0.8, 0.8, 1.0), specular=0.0)
"""What a surface has that names no material: matt grey."""

_LIBRARY = re.compile(r"\S.*?\.mtl(?=\s|$)", re.IGNORECASE)
_USED = {"kd", "ke", "ks", "ns", "ni", "d", "tr", "pr", "pm", "map_kd", "map_ke", "map_d", "map_pr", "map_pm", "norm"}
_USED |= {"map_bump", "bump"}
# What these say without changing anything: the usual model of light, no ambient light, a filter that lets all through.
_NEUTRAL = {"illum": (2.0,), "ka": (0.0, 0.0, 0.0), "tf": (1.0, 1.0, 1.0)}


def phong_roughness(exponent: float) -> float:
    """The roughness that is like Phong's exponent n: of microfacets with α² = 2 / (n + 2), where α is roughness²."""
    return (2.0 / (exponent + 2.0)) ** 0.25


class MaterialLibrary:
    """The materials that an OBJ file's libraries define; those that are asked for, with their textures."""

    def __init__(self, scene: Path, limits: SceneLimits, remarks: Remarks) -> None:
        self._maps = MapFiles(scene, limits, remarks)
        self._scene, self._limits, self._remarks = scene, limits, remarks
        self._defined: dict[str, tuple[MtlMaterial, Path]] = {}
        self._done: set[Path] = set()

    @property
    def textures(self) -> list[Texture]:
        """The textures of the materials that were asked for."""
        return self._maps.textures

    def read(self, names: str) -> None:
        """Add the materials of the libraries `names`, what follows an mtllib: one or several, with spaces or without.

        Instead of a missing one that of the scene's own name is read, as of files that were renamed, and either is
        said; of materials of one name the first counts. Raises SceneError for one outside the folder.
        """
        for name in self._libraries(names):
            path = self._maps.find(name, "mtllib")
            if path is None:
                path = self._maps.find(f"{self._scene.stem}.mtl", "mtllib")
                instead = f"{path.name} was read" if path is not None else "its surfaces are grey"
                self._remarks.add(f"material library {name} is missing: {instead}")
            if path is None or path in self._done:
                continue
            self._done.add(path)
            for material in read_materials(path.name, decoded(read_bytes(path, self._limits)), self._remarks):
                if self._defined.setdefault(material.name, (material, path))[0] is not material:
                    self._remarks.add(f"material {material.name} is defined twice: the first counts")
                self._defined.setdefault(uncommented(material.name), (material, path))

    def _libraries(self, names: str) -> list[str]:
        """The names in `names`: all of it where there is such a file, else each up to its .mtl, else each word."""
        whole = names.strip('"')
        if self._maps.find(whole, "mtllib") is not None:
            return [whole]
        return [name.strip('"') for name in _LIBRARY.findall(names) or uncommented(names).split()]

    def find(self, name: str) -> Material | None:
        """The material called `name`, None where no library defines it, which is said."""
        found = self._defined.get(name) or self._defined.get(uncommented(name))
        if found is None:
            if name:
                self._remarks.add(f"material {name} is not defined: its surfaces are grey")
            return None
        said, path = found
        for key, (value, _) in said.values.items():
            if key not in _USED and _numbers_of(value) != _NEUTRAL.get(key, ()):
                self._remarks.add(f"{key} of MTL materials is not supported and was ignored")
        return self._textured(said, path, self._plain(said, name))

    def _plain(self, said: MtlMaterial, name: str) -> Material:
        """The material without its maps."""
        shines = said.has("pr") or said.has("pm") or said.has("map_pr") or said.has("map_pm")
        specular = said.color("ks", (1.0, 1.0, 1.0) if shines else (0.0, 0.0, 0.0))
        roughness = phong_roughness(said.scalar("ns", 0.0))
        opacity = self._opacity(said)
        ior = said.scalar("ni", 1.5)
        return replace(
            DEFAULT_MATERIAL,
            name=name,
            base_color=(*said.color("kd", (0.8, 0.8, 0.8), most=1.0), opacity),
            emission=said.color("ke", (0.0, 0.0, 0.0)),
            specular=float(max(specular) > 0.0),
            roughness=said.scalar("pr", roughness, most=1.0),
            metallic=said.scalar("pm", 0.0, most=1.0),
            ior=ior if ior > 1.0 else 1.5,  # 1 is what programs write that know no index of refraction
            alpha_mode=AlphaMode.BLEND if opacity < 1.0 else AlphaMode.OPAQUE,
        )

    def _opacity(self, said: MtlMaterial) -> float:
        """Opacity 0–1 by d, else by Tr, its opposite."""
        if said.has("d") or not said.has("tr"):
            opacity = said.scalar("d", 1.0, most=1.0)
        else:
            transparency = said.scalar("tr", 0.0, most=1.0)
            if transparency == 1.0:
                self._remarks.add("Tr 1 without d was taken as opaque, as programs mean it that swap both", said.name)
            opacity = 1.0 - transparency if transparency < 1.0 else 1.0
        if opacity == 0.0:
            self._remarks.add("is not seen at all, since its d is 0", f"material {said.name}")
        return opacity

    def _textured(self, said: MtlMaterial, path: Path, material: Material) -> Material:
        """`material` with its maps, as far as there are such files."""
        base, mask = (self._maps.image(said, key, path) for key in ("map_kd", "map_d"))
        if base or mask:
            white = (1.0, 1.0, 1.0) if base else material.base_color[:3]
            # With a texture, exporters write any Kd: the texture alone is the colour.
            material = replace(
                material,
                base_color=(*white, material.base_color[3]),
                base_color_slot=self._maps.color_slot(base, mask),
                alpha_mode=AlphaMode.BLEND if mask else material.alpha_mode,
            )
        if emission := self._maps.image(said, "map_ke", path):
            color = material.emission if any(material.emission) else (1.0, 1.0, 1.0)
            material = replace(material, emission=color, emission_slot=self._maps.color_slot(emission, None))
        rough, metal = (self._maps.image(said, key, path) for key in ("map_pr", "map_pm"))
        if rough or metal:
            material = replace(
                material,
                roughness=1.0 if rough and not said.has("pr") else material.roughness,
                metallic=1.0 if metal and not said.has("pm") else material.metallic,
                metallic_roughness_slot=self._maps.rough_metal_slot(rough, metal),
            )
        if normal := self._normals(said, path):
            slot = self._maps.data_slot(normal)
            material = replace(material, normal_slot=slot, normal_scale=normal.statement.bump)
        return material

    def _normals(self, said: MtlMaterial, path: Path) -> MapImage | None:
        """The map of normals, else that of bumps where it is one, as Blender and others write it; heights are none."""
        found = self._maps.image(said, "norm", path)
        for key in filter(said.has, ("map_bump", "bump")):
            bumps = self._maps.image(said, key, path) if found is None else None
            if bumps is not None and is_normal_map(bumps.pixels):
                self._remarks.add(f"a {key} of MTL materials that has the colours of a normal map was taken as one")
                found = bumps
            else:
                self._remarks.add(f"{key} of MTL materials is not supported and was ignored")
        return found


def _numbers_of(value: str) -> tuple[float, ...] | None:
    """The numbers of a statement, None where it has words that are none."""
    try:
        return tuple(float(word) for word in uncommented(value).split())
    except ValueError:
        return None
