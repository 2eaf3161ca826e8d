"""IFC files (.ifc, .ifczip), read by IfcOpenShell: https://docs.ifcopenshell.org."""

from pathlib import Path

from gpu.errors import SceneError
from gpu.scene.assemble import assemble
from gpu.scene.formats.extras import library
from gpu.scene.formats.ifc.geometry import Geometry
from gpu.scene.formats.ifc.georeference import georeference
from gpu.scene.formats.ifc.model import open_model
from gpu.scene.formats.ifc.products import choose_products
from gpu.scene.formats.ifc.unshown import unshown_kinds
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Scene


def load_ifc(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The bodies of the building in the IFC file at `path`, openings cut, those of `options.storeys` if any is named.

    Raises SceneError when the file is broken or cut off, its schema is not known, a storey does not exist, a limit is
    exceeded, or the library is not installed.
    """
    try:
        found = _parts(path, limits, options)
    except (AttributeError, TypeError) as error:  # an entity refers to one of another kind
        raise SceneError(str(path), "", f"is not as its schema says: {error}") from error
    return assemble(str(path), found, limits, options)


def _parts(path: Path, limits: SceneLimits, options: ImportOptions) -> SceneParts:
    geom = library(str(path), "ifcopenshell.geom", "ifc")
    model, broken = open_model(path, limits)
    chosen = choose_products(str(path), model, options.storeys)
    geometry = Geometry(str(path), geom, model, limits)
    parts = geometry.parts(chosen.shown)
    return SceneParts(
        parts,
        geometry.styles.materials,
        ignored=[*broken, *chosen.sentences, *geometry.sentences, *unshown_kinds(model)],
        notes=[*geometry.notes, *georeference(model)],
        up="z",
        metres_per_unit=geometry.metres_per_unit,
        choices={"storey": chosen.storeys},
    )
