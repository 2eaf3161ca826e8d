"""The camera that a view means in a scene."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import tan

import numpy as np

from gpu.errors import UserError, brief
from gpu.scene.camera import look_at
from gpu.scene.camera_path import CameraPath
from gpu.scene.types import Camera, Scene
from server.scenes.scene_info import MOST_CAMERAS
from server.wire.browser import SceneInfo
from server.wire.worker import AlongPath, CameraMatrix, CameraSpec, LookAt, SceneCamera

MOST_NAMED = 10  # of a scene's cameras, where there is not the one that was asked for


def view_camera(scene: Scene, view: CameraSpec, size: tuple[int, int]) -> Camera:
    """The camera that a view means, for pictures of `size`; UserError when the scene has no such camera."""
    aspect = size[0] / size[1]
    match view:
        case LookAt(position, target, up, yfov_degrees, near):
            eye, aim = (scene.frame.to_world(np.array(point)).tolist() for point in (position, target))
            upward = (0.0, 1.0, 0.0) if up is None else scene.frame.turned(np.array(up)).tolist()
            return replace(look_at(eye, aim, upward, yfov_degrees, aspect), near=near)
        case CameraMatrix(matrix, yfov, near):
            return Camera("", np.array(matrix).reshape(4, 4).T, tan(yfov / 2.0), aspect, near=near)
        case AlongPath(_, time):
            return camera_path(scene, view, size).at(time)
        case SceneCamera(int(index)) if 0 <= index < len(scene.cameras):
            return replace(scene.cameras[index], aspect=aspect)
        case SceneCamera(str(name)):
            for camera in scene.cameras:
                if camera.name == name:
                    return replace(camera, aspect=aspect)
    raise _missing(scene.name, [camera.name for camera in scene.cameras], view)


def check_view(info: SceneInfo, view: CameraSpec) -> None:
    """Raise UserError, as `view_camera` would, for a view by a camera that a scene has not; of cameras that are not
    listed, since they are too many, nothing is known.
    """
    if isinstance(view, AlongPath):
        for index, (_, keyframe) in enumerate(view.keyframes):
            with _of_keyframe(index):
                check_view(info, keyframe)
    elif isinstance(view, SceneCamera) and len(info.cameras) < MOST_CAMERAS:
        names = [camera.name for camera in info.cameras]
        if view.camera not in (*names, *range(len(names))):
            raise _missing(info.id, names, view)


@contextmanager
def _of_keyframe(index: int) -> Iterator[None]:
    try:
        yield
    except UserError as error:
        raise UserError(f"keyframes[{index}].{error}") from None


def _missing(scene: str, names: Sequence[str], view: SceneCamera) -> UserError:
    listed = ", ".join(f"{index} ({name})" for index, name in enumerate(names[:MOST_NAMED]))
    there = listed + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")
    return UserError(f"camera: {scene} has no camera {brief(repr(view.camera), 80)}; it has {there}")


def camera_path(scene: Scene, view: AlongPath, size: tuple[int, int]) -> CameraPath:
    """The whole way of a camera in a scene; UserError that names the keyframe whose view there is not."""
    cameras = []
    for index, (_, keyframe) in enumerate(view.keyframes):
        with _of_keyframe(index):
            cameras.append(view_camera(scene, keyframe, size))
    return CameraPath([time for time, _ in view.keyframes], cameras)
