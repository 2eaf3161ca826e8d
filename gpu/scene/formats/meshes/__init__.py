"""PLY, STL and OFF files: bare meshes, matt grey or with the colours of their vertices or faces."""

from pathlib import Path

from gpu.scene.assemble import assemble
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.mesh_colors import bare_material
from gpu.scene.formats.meshes.off import read_off
from gpu.scene.formats.meshes.ply import read_ply
from gpu.scene.formats.meshes.stl import read_stl
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Scene

_READERS = {".ply": read_ply, ".stl": read_stl, ".off": read_off}


def load_mesh(path: Path, limits: SceneLimits, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the PLY, STL or OFF file at `path`. Raises SceneError when it is broken or cut off."""
    remarks = Remarks()
    part = _READERS[path.suffix.lower()](str(path), read_bytes(path, limits), remarks)
    found = SceneParts([part], [bare_material(part.colors)], ignored=remarks.sentences())
    return assemble(str(path), found, limits, options)
