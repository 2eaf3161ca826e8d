"""The container of an IFC file: STEP text (ISO 10303-21), plain or zipped, to IfcOpenShell's model of it."""

from pathlib import Path
from typing import Any

from gpu.errors import SceneError
from gpu.scene.formats.extras import library
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.package import Package
from gpu.scene.limits import SceneLimits

_END = b"END-ISO-10303-21;"


def open_model(path: Path, limits: SceneLimits) -> tuple[Any, list[str]]:
    """The model in the file at `path`, and a sentence on statements that are broken and were left out.

    Raises SceneError when it is no IFC file, is cut off, or has a schema that IfcOpenShell does not know.
    """
    ifcopenshell = library(str(path), "ifcopenshell", "ifc")
    content = read_bytes(path, limits)
    if path.suffix.lower() == ".ifczip":
        content = _unzipped(path, content, limits)
    if not content.lstrip().startswith(b"ISO-10303-21;"):
        raise SceneError(str(path), "", "not an IFC file: it does not begin with ISO-10303-21;")
    if not content.rstrip().endswith(_END):
        raise SceneError(str(path), "", f"the file is cut off: it does not end with {_END.decode()}")
    ifcopenshell.get_log()  # which empties it of what earlier files left
    try:
        model = ifcopenshell.file.from_string(content.decode("latin-1"))
        _ = model.schema  # which is where an unknown one is told
    except RuntimeError as error:
        problem = "has no schema that is known; export it as IFC2X3, IFC4 or IFC4X3"
        raise SceneError(str(path), "FILE_SCHEMA", problem) from error
    lines = ifcopenshell.get_log().splitlines()
    errors = [line.rpartition("] ")[2] for line in lines if line.startswith("[error]")]
    if not errors:
        return model, []
    return model, [f"statements with errors, left out: {len(errors)} (the first: {errors[0]:.200})"]


def _unzipped(path: Path, content: bytes, limits: SceneLimits) -> bytes:
    """The one .ifc file in a .ifczip. Raises SceneError."""
    package = Package(path, content, limits)
    names = [name for name in package.names if name.lower().endswith(".ifc")]
    if len(names) != 1:
        raise SceneError(str(path), "", f"{len(names)} .ifc files in the .ifczip; there must be one")
    return package.read(names[0])
