"""STEP files (ISO 10303, AP203, AP214, AP242), made triangles by Open CASCADE (the package cascadio)."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gpu.errors import SceneError
from gpu.scene.assemble import assemble
from gpu.scene.formats.extras import library
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.gltf import gltf_parts
from gpu.scene.formats.gltf.document import read_document
from gpu.scene.formats.gltf.materials import DEFAULT_MATERIAL as GLTF_DEFAULT
from gpu.scene.formats.mtl import DEFAULT_MATERIAL
from gpu.scene.formats.printed import printed_lines
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Doubles, Material, Scene

# How far triangles may be from a curved surface: a distance [mm], and the angle between neighbours [rad], which decides
# for small parts.
_DEFLECTION, _ANGLE = 1.0, 0.25
_MILLIMETRE = 0.001
_PREFIXES = {b"": 1.0, b"MICRO": 1e-6, b"MILLI": 1e-3, b"CENTI": 1e-2, b"DECI": 0.1, b"KILO": 1e3}
_NAMED = {b"INCH": 0.0254, b"FOOT": 0.3048, b"YARD": 0.9144, b"MILE": 1609.344}


def load_step(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The bodies in the STEP file at `path`, matt in their colours, grey where they have none.

    Raises SceneError when the file is broken, a limit is exceeded, or the library is not installed.
    """
    cascadio = library(str(path), "cascadio", "step")
    content = read_bytes(path, limits)
    with printed_lines() as printed:
        try:
            glb = cascadio.load(content, "step", tol_linear=_DEFLECTION, tol_angular=_ANGLE, use_parallel=False)
        except RuntimeError as error:
            raise SceneError(str(path), "", f"not a STEP file that can be read: {error}") from error
    said = [line.strip("* ") for line in printed if line.startswith("**")]
    found = gltf_parts(read_document(path, glb, limits)) if glb else SceneParts((), ())
    if said and not found.meshes:
        raise SceneError(str(path), "", f"not a STEP file that can be read: {said[0]:.200}")
    unit = metres_per_unit(content)
    # What Open CASCADE writes is in metres, with the file's axes; its materials say no metalness, which is 1 in glTF.
    meshes = [replace(part, positions=_single(part.positions / unit)) for part in found.meshes]
    materials = [_matt(material) for material in found.materials]
    plain = sum(materials[part.material] is DEFAULT_MATERIAL for part in meshes)
    ignored = [*found.ignored, *_broken(said)]
    notes = [*found.notes, *([f"bodies without a colour, which are grey: {plain}"] if plain else [])]
    step = SceneParts(meshes, materials, ignored=ignored, notes=notes, up="z", metres_per_unit=unit)
    return assemble(str(path), step, limits, options)


def metres_per_unit(content: bytes) -> float:
    """The unit of length of a STEP file's first shapes; a millimetre, as Open CASCADE has it, where it names none."""
    assigned = re.search(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)", content)
    for number in re.findall(rb"#\d+", assigned[1]) if assigned else ():
        unit = re.search(number + rb"\s*=([^;]*LENGTH_UNIT[^;]*);", content)
        if unit and (named := re.search(rb"CONVERSION_BASED_UNIT\s*\(\s*'\s*([A-Z]+)", unit[1].upper())):
            return _NAMED.get(named[1], _MILLIMETRE)
        if unit and (metric := re.search(rb"SI_UNIT\s*\(\s*(?:\$|\.([A-Z]+)\.)\s*,\s*\.METRE\.", unit[1].upper())):
            return _PREFIXES.get(metric[1] or b"", _MILLIMETRE)
    return _MILLIMETRE


def _single(positions: Doubles) -> Doubles:
    """`positions` as they are in single precision, so that it is told where that is too coarse."""
    return positions.astype(np.float32).astype(np.float64)


def _matt(material: Material) -> Material:
    if material is GLTF_DEFAULT:
        return DEFAULT_MATERIAL
    return replace(material, metallic=0.0, specular=0.0)


def _broken(said: Sequence[str]) -> list[str]:
    """A sentence on what Open CASCADE could not read, of the lines that it printed."""
    return [f"parts of the file are broken and were left out; Open CASCADE says: {said[0]:.200}"] if said else []
