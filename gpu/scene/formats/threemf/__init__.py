"""3MF scenes (.3mf): https://3mf.io/spec, with the materials and production extensions."""

from pathlib import Path

import numpy as np

from gpu.scene.assemble import assemble
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.threemf.meshes import Meshes
from gpu.scene.formats.threemf.model import Key, Model
from gpu.scene.formats.threemf.properties import Properties
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.transforms import placed
from gpu.scene.types import Doubles, Scene
from gpu.scene.validate import check_count


def load_threemf(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """What the 3MF file at `path` builds. Raises SceneError for what is broken or too large."""
    remarks = Remarks()
    model = Model(path, read_bytes(path, limits), limits, remarks)
    properties = Properties(model)
    scene = SceneParts(
        meshes=_parts(model, Meshes(model, properties)),
        materials=properties.materials,
        textures=properties.textures,
        ignored=remarks.sentences(),
        up="z",
        metres_per_unit=model.metres_per_unit,
    )
    return assemble(str(path), scene, limits, options)


def _parts(model: Model, meshes: Meshes) -> list[MeshPart]:
    """The parts of all objects that are built, at all their places."""
    places: dict[Key, list[Doubles]] = {}
    for matrix, key in model.built():
        places.setdefault(key, []).append(matrix)
    found, triangles = [], 0
    for key, matrices in places.items():
        for part in meshes.of(key):
            triangles += len(part.triangles) * len(matrices)
            check_count(str(model.path), "triangles", triangles, model.limits.max_triangles, "max_triangles")
            found.append(placed(part, np.stack(matrices)))
    return found
