"""The scene that a service begins with, and what the worker is told of a scene."""

from pathlib import Path

from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import ImportOptions
from server.refusals import UnknownSceneError
from server.wire.worker import SceneRef


def served_scene(source: str, options: ImportOptions) -> SceneRef:
    """The scene of a file or a built-in name that a service begins with; UserError where there is none."""
    check_served(source)
    return scene_ref(served_id(source), source, options)


def check_served(source: str) -> None:
    """UserError where there is no such file or built-in scene."""
    if source not in BUILTIN and not Path(source).is_file():
        raise UserError(f"{source}: there is no such file, nor a built-in scene of that name ({', '.join(BUILTIN)})")


def served_id(source: str) -> str:
    """The public id of the scene that a service begins with."""
    return source if source in BUILTIN else Path(source).name


def scene_ref(scene_id: str, source: str, options: ImportOptions) -> SceneRef:
    """A scene as its file is now; UnknownSceneError where that cannot be read."""
    if source in BUILTIN:
        return SceneRef(scene_id, source, options=options)
    try:
        return SceneRef(scene_id, source, Path(source).stat().st_mtime_ns, options)
    except OSError as error:
        raise UnknownSceneError(f"scene: {scene_id!r} cannot be read: {error.strerror}") from None
