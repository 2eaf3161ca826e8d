"""glTF 2.0 files (.gltf, .glb), read from their JSON: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html."""

from itertools import product
from pathlib import Path

import numpy as np

from gpu.scene.assemble import assemble
from gpu.scene.formats.gltf.animations import Movable, motion_of, moved_nodes, read_animations, with_turned
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.cameras_and_lights import read_cameras, read_lights
from gpu.scene.formats.gltf.document import Document, open_document
from gpu.scene.formats.gltf.extensions import check_extensions
from gpu.scene.formats.gltf.geometry import Geometry
from gpu.scene.formats.gltf.hierarchy import placed_nodes
from gpu.scene.formats.gltf.images import Images
from gpu.scene.formats.gltf.materials import DEFAULT_MATERIAL, read_materials
from gpu.scene.formats.gltf.unused import say_unused
from gpu.scene.formats.gltf.variants import chosen_variant, variant_names
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Doubles, Scene


def load_gltf(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the glTF or GLB file at `path`, in the pose that the file has without animation.

    Raises SceneError, naming the place in the JSON, for geometry that is broken and for what is too large, required but
    not supported, or outside the file's folder. What else is broken is left out or mended; that and what is not used is
    in the scene's report.
    """
    return assemble(str(path), gltf_parts(open_document(path, limits), options.variant), limits, options)


def gltf_parts(document: Document, variant: str | None = None) -> SceneParts:
    """What is in the scene of `document`, with the materials of its `variant`. Raises SceneError as load_gltf does."""
    check_extensions(document)
    buffers = Buffers(document)
    images = Images(buffers)
    materials = [*read_materials(images), DEFAULT_MATERIAL]
    placed = placed_nodes(document)
    lights = read_lights(document, placed.values())
    animations = read_animations(buffers, Movable(placed, [light.number for light in lights]))
    moved = moved_nodes(animations, placed)
    geometry = Geometry(buffers, materials, chosen_variant(document, variant), moved)
    parts, turned = geometry.settled(geometry.parts(placed))
    animations = with_turned(animations, turned)
    cameras = read_cameras(document, placed.values(), _box(parts))
    say_unused(document, placed.values(), materials)
    # The format's metre is not what every file keeps to: it is taken where the size is likely.
    return SceneParts(
        parts,
        materials,
        images.textures,
        [light.light for light in lights],
        [camera for camera, _ in cameras],
        ignored=document.ignored.sentences(),
        notes=document.notes.sentences(),
        up="y",
        choices={"variant": variants} if (variants := variant_names(document)) else {},
        motion=motion_of(animations, placed, [light.node for light in lights], [number for _, number in cameras]),
    )


def _box(parts: list[MeshPart]) -> Doubles:
    """The corners (corner, 3) of the box around all parts."""
    if not parts:
        return np.zeros((0, 3))
    low = np.min([part.positions.min(axis=0) for part in parts], axis=0)
    high = np.max([part.positions.max(axis=0) for part in parts], axis=0)
    return np.array(list(product(*zip(low, high, strict=True))))
