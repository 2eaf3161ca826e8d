"""FBX files in their text form, for tests."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

SQUARE = (0, 0, 0, 100, 0, 0, 100, 100, 0, 0, 100, 0)


def properties(**values: Any) -> str:
    """A Properties70 block of numbers, integers and triples."""
    kinds = {int: '"int", "Integer"', float: '"double", "Number"', tuple: '"Vector3D", "Vector"'}
    lines = []
    for name, value in values.items():
        text = (
            ",".join(map(str, value)) if isinstance(value, tuple) else f'"{value}"' if isinstance(value, str) else value
        )
        name = name.replace("_", " ")
        lines.append(f'P: "{name}", {kinds[type(value)]}, "",{text}')
    return "Properties70:  {\n" + "\n".join(lines) + "\n}\n"


class FbxFile:
    """A file in the making: objects with numbers, and connections between them. Centimetres, Y up."""

    def __init__(self, folder: Path, up: int = 1) -> None:
        self.folder = folder
        front = {1: (2, 1), 2: (1, -1)}[up]
        self.settings = properties(UpAxis=up, UpAxisSign=1, FrontAxis=front[0], FrontAxisSign=front[1], CoordAxis=0,
                                   CoordAxisSign=1, UnitScaleFactor=1.0)  # fmt: skip
        self.objects: list[str] = []
        self.connections: list[str] = []

    def add(self, kind: str, name: str, type_: str, body: str, to: int | str | None = None) -> int:
        """An object, connected to another, or to its property when `to` is "number:property"."""
        number = 100 + len(self.objects)
        self.objects.append(f'{kind}: {number}, "{kind}::{name}", "{type_}" {{\n{body}}}\n')
        if to is not None:
            owner, _, name = str(to).partition(":")
            self.connections.append(f'C: "OP",{number},{owner}, "{name}"' if name else f'C: "OO",{number},{owner}')
        return number

    def node(self, name: str, type_: str, **values: Any) -> int:
        return self.add("Model", name, type_, "Version: 232\n" + properties(**values), 0)

    def mesh(
        self,
        node: int,
        points: Sequence[float] = SQUARE,
        polygons: str = "0,1,2,-4",
        materials: Sequence[int] = (),
        uv: bool = True,
    ) -> int:
        """A mesh; its polygons end with a corner that is negative, minus one."""

        def numbers(name: str, values: Any) -> str:
            return f"{name}: *{len(str(values).split(','))} {{\na: {values}\n}}\n"

        layers, body = "", numbers("Vertices", ",".join(map(str, points))) + numbers("PolygonVertexIndex", polygons)
        if uv:
            body += ('LayerElementUV: 0 {\nVersion: 101\nName: "map"\nMappingInformationType: "ByPolygonVertex"\n'
                     'ReferenceInformationType: "Direct"\n' + numbers("UV", "0,0,1,0,1,1,0,1") + "}\n")  # fmt: skip
            layers += 'LayerElement:  {\nType: "LayerElementUV"\nTypedIndex: 0\n}\n'
        if materials:
            body += ('LayerElementMaterial: 0 {\nVersion: 101\nName: ""\nMappingInformationType: "ByPolygon"\n'
                     'ReferenceInformationType: "IndexToDirect"\n'
                     + numbers("Materials", ",".join(map(str, materials))) + "}\n")  # fmt: skip
            layers += 'LayerElement:  {\nType: "LayerElementMaterial"\nTypedIndex: 0\n}\n'
        return self.add("Geometry", "Mesh", "Mesh", body + "Layer: 0 {\nVersion: 100\n" + layers + "}\n", node)

    def material(self, node: int, name: str, **values: Any) -> int:
        """A Phong material."""
        return self.add("Material", name, "", 'Version: 102\nShadingModel: "phong"\n' + properties(**values), node)

    def texture(self, material: int, file: str, prop: str = "DiffuseColor", relative: str = "") -> int:
        body = f'Type: "TextureVideoClip"\nVersion: 202\nFileName: "{file}"\nRelativeFilename: "{relative}"\n'
        return self.add("Texture", "T", "", body, f"{material}:{prop}")

    def attribute(self, node: int, type_: str, **values: Any) -> int:
        """A light or a camera."""
        return self.add("NodeAttribute", type_, type_, f'TypeFlags: "{type_}"\n' + properties(**values), node)

    def write(self, name: str = "scene.fbx") -> Path:
        head = "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n"
        settings = "GlobalSettings:  {\nVersion: 1000\n" + self.settings + "}\n"
        objects = "Objects:  {\n" + "".join(self.objects) + "}\n"
        path = self.folder / name
        path.write_text(head + settings + objects + "Connections:  {\n" + "\n".join(self.connections) + "\n}\n")
        return path
