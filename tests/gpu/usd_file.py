"""USD files made by USD itself, for tests. Who imports this is skipped where usd-core is not installed."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from gpu.scene.types import Doubles, Scene

pytest.importorskip("pxr")

from pxr import Sdf, Usd, UsdGeom, UsdShade

from gpu.scene.formats.usd import load_usd

SQUARE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))
TYPES = {
    float: Sdf.ValueTypeNames.Float,
    int: Sdf.ValueTypeNames.Int,
    str: Sdf.ValueTypeNames.Token,
    Sdf.AssetPath: Sdf.ValueTypeNames.Asset,
    tuple: Sdf.ValueTypeNames.Float3,
}


class UsdFile:
    """A stage in memory that is written as scene.usda; its units are metres, Y is up."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.y)

    def mesh(self, path: str = "/Mesh", points: Any = SQUARE, counts: Any = (4,), indices: Any = None) -> Any:
        """A polygon mesh, one square without more."""
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.CreatePointsAttr(points)
        mesh.CreateFaceVertexCountsAttr(counts)
        mesh.CreateFaceVertexIndicesAttr(list(range(len(points))) if indices is None else indices)
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        return mesh

    def primvar(self, mesh: Any, name: str, kind: str, interpolation: str, values: Any) -> None:
        """A primvar whose type has the name `kind`, such as "TexCoord2fArray"."""
        primvars = UsdGeom.PrimvarsAPI(mesh)
        primvars.CreatePrimvar(name, getattr(Sdf.ValueTypeNames, kind), interpolation).Set(values)

    def shader(self, path: str, kind: str, **inputs: Any) -> Any:
        """A shader with inputs of values, or connected to (shader, output)."""
        shader = UsdShade.Shader.Define(self.stage, path)
        shader.CreateIdAttr(kind)
        for name, value in inputs.items():
            if isinstance(value, tuple) and isinstance(value[0], UsdShade.Shader):
                output = value[0].CreateOutput(value[1], Sdf.ValueTypeNames.Float3)
                shader.CreateInput(name, Sdf.ValueTypeNames.Float3).ConnectToSource(output)
            else:
                kinds = {2: Sdf.ValueTypeNames.Float2, 3: Sdf.ValueTypeNames.Float3, 4: Sdf.ValueTypeNames.Float4}
                kind_of = kinds[len(value)] if isinstance(value, tuple) else TYPES[type(value)]
                shader.CreateInput(name, kind_of).Set(value)
        return shader

    def texture(self, path: str, file: str, **inputs: Any) -> Any:
        """A UsdUVTexture of `file`."""
        return self.shader(path, "UsdUVTexture", file=Sdf.AssetPath(file), **inputs)

    def material(self, mesh: Any, path: str = "/Material", **inputs: Any) -> Any:
        """A UsdPreviewSurface bound to `mesh`."""
        material = UsdShade.Material.Define(self.stage, path)
        surface = self.shader(f"{path}/Surface", "UsdPreviewSurface", **inputs)
        material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        return material

    def image(self, name: str, pixels: Any) -> str:
        """An image file of `pixels` (height, width, 3 or 4); returns its name."""
        Image.fromarray(np.array(pixels, np.uint8)).save(self.folder / name)
        return name

    def write(self, name: str = "scene.usda") -> Path:
        """The file written, of the kind that the name says."""
        self.stage.GetRootLayer().Export(str(self.folder / name))
        return self.folder / name

    def load(self) -> Scene:
        """The scene of the file."""
        return load_usd(self.write())


def world(scene: Scene) -> Doubles:
    """World positions (triangle, 3, 3) of the corners of a scene's triangles."""
    vertices = scene.vertices.astype(np.float64) / scene.placement.scale + scene.placement.centre
    return vertices[scene.triangles]


def facing(scene: Scene) -> Doubles:
    """Area vectors (triangle, 3): geometric normals of length twice the area."""
    corners = world(scene)
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
