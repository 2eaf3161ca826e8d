"""A scene by the path of its file or by the name of a built-in one."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gpu.errors import SceneError
from gpu.scene.builtin import BUILTIN
from gpu.scene.formats.files import noting_files
from gpu.scene.formats.usd.layers import LAYERS
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import Scene
from gpu.scene.wording import shortened

SUFFIXES = (
    *(".glb", ".gltf", ".obj", ".ply", ".stl", ".off", ".fbx", ".ifc", ".ifczip", ".step", ".stp"),
    *(".dae", ".zae", ".3mf"),
    *LAYERS,
)
"""How the names of scene files end, in lower case."""
_PACKED = (".zip", ".7z", ".rar", ".gz", ".tgz", ".tar", ".bz2", ".xz")
WRITTEN_IN_MEMORY = (".step", ".stp")
"""Those of SUFFIXES whose library writes a file, in memory, to read it."""
READ_BY_A_PROCESS = (".fbx",)
"""Those of SUFFIXES whose reader starts a process."""


def load_scene(source: str, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The built-in scene called `source`, or the scene in the file at that path, read as `options` say.

    What a file says of itself is cut where it is too long (gpu.scene.wording).
    Raises SceneError when there is no such scene, its format is not known, or its content is not sound.
    """
    if source in BUILTIN:
        if options != DEFAULT_OPTIONS:
            raise SceneError(source, "", "is built in: how it is read is no choice; up, unit and others are for files")
        return BUILTIN[source]()
    path = Path(source)
    if path.suffix.lower() in _PACKED:
        raise SceneError(
            source, "", "is an archive; unpack it and give the scene's file, or upload a .zip to the service"
        )
    if path.suffix.lower() not in SUFFIXES:
        known = f"one of {', '.join(BUILTIN)}, or a file that ends in {', '.join(SUFFIXES)}"
        raise SceneError(source, "", f"is not a scene; give {known}")
    with noting_files() as files:
        scene = shortened(_reader(path.suffix.lower())(path, limits, options))
    folder = path.parent.resolve()
    beside = {file.relative_to(folder).as_posix(): written for file, written in files.items()}
    return replace(scene, report=replace(scene.report, beside=beside))


def _reader(suffix: str) -> Callable[[Path, SceneLimits, ImportOptions], Scene]:
    """The reader of files with `suffix`, imported when first wanted: some bring large libraries."""
    if suffix in (".glb", ".gltf"):
        from gpu.scene.formats.gltf import load_gltf

        return load_gltf
    if suffix == ".obj":
        from gpu.scene.formats.obj import load_obj

        return load_obj
    if suffix in (".dae", ".zae"):
        from gpu.scene.formats.collada import load_collada

        return load_collada
    if suffix == ".3mf":
        from gpu.scene.formats.threemf import load_threemf

        return load_threemf
    if suffix == ".fbx":
        from gpu.scene.formats.fbx import load_fbx

        return load_fbx
    if suffix in (".ifc", ".ifczip"):
        from gpu.scene.formats.ifc import load_ifc

        return load_ifc
    if suffix in (".step", ".stp"):
        from gpu.scene.formats.step import load_step

        return load_step
    if suffix.startswith(".usd"):
        from gpu.scene.formats.usd import load_usd

        return load_usd
    from gpu.scene.formats.meshes import load_mesh

    return load_mesh
