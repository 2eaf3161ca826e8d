"""OBJ files, with the materials of their MTL files."""

from dataclasses import replace
from pathlib import Path

from gpu.scene.assemble import assemble
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.mesh_colors import bare_material
from gpu.scene.formats.mtl import MaterialLibrary
from gpu.scene.formats.obj.faces import ObjParts
from gpu.scene.formats.obj.statements import read_statements
from gpu.scene.formats.text import decoded
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Scene


def load_obj(path: Path, limits: SceneLimits, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the OBJ file at `path`, with the materials of its MTL files (Ke is emission).

    Raises SceneError naming the line of what is broken, and for files outside the scene's folder.
    """
    remarks = Remarks()
    text = decoded(read_bytes(path, limits))
    file = read_statements(str(path), text, remarks)
    library = MaterialLibrary(path, limits, remarks)
    for libraries in file.libraries:
        library.read(libraries)
    geometry = ObjParts(file, text, remarks)
    names = list(dict.fromkeys(name for name, _ in file.faces))
    bare = bare_material(geometry.colors)
    materials = [library.find(name) or replace(bare, name=name or bare.name) for name in names]
    parts = geometry.parts({name: number for number, name in enumerate(names)})
    found = SceneParts(parts, materials, library.textures, ignored=remarks.sentences())
    return assemble(str(path), found, limits, options)
