"""A view as a user writes it: a picture's size, and a camera by name, number or position."""

from dataclasses import replace

import numpy as np

from gpu.errors import UserError
from gpu.scene.camera import look_at
from gpu.scene.file_frame import FileFrame
from gpu.scene.types import Camera, Scene
from server.wire.browser import MAX_SIDE


def parse_size(text: str) -> tuple[int, int]:
    """Return (width, height) from "WxH" in pixels; raises UserError unless both are 1 to MAX_SIDE."""
    try:
        width, height = (int(side) for side in text.lower().split("x"))
    except ValueError:
        raise UserError(f"--size: {text!r} is not WIDTHxHEIGHT, for example 960x540") from None
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise UserError(f"--size: {text}: each side must be 1 to {MAX_SIDE} pixels")
    return width, height


def choose_camera(scene: Scene, text: str, aspect: float) -> Camera:
    """Return the scene's camera of that name or number, or the one that "x,y,z:tx,ty,tz[:yfov]" describes.

    The points are in the coordinates of the scene's file, yfov in degrees (60 when left out); aspect: width over height
    of the picture.
    Raises UserError, which lists the scene's cameras, when `text` is none of these.
    """
    for camera in scene.cameras:
        if camera.name == text:
            return replace(camera, aspect=aspect)
    if text.isdecimal() and int(text) < len(scene.cameras):
        return replace(scene.cameras[int(text)], aspect=aspect)
    if ":" in text:
        return _from_position(text, scene.frame, aspect)
    known = ", ".join(f"{number} {camera.name!r}" for number, camera in enumerate(scene.cameras))
    raise UserError(f'--camera: {scene.name} has no camera {text!r}; it has {known}; or write "x,y,z:tx,ty,tz[:yfov]"')


def _from_position(text: str, frame: FileFrame, aspect: float) -> Camera:
    try:
        eye, target, *angle = [[float(number) for number in part.split(",")] for part in text.split(":")]
        if len(eye) != 3 or len(target) != 3 or len(angle) > 1 or any(len(part) != 1 for part in angle):
            raise ValueError
    except ValueError:
        raise UserError(f'--camera: {text!r} is not "x,y,z:tx,ty,tz[:yfov]", for example 0,1.6,3:0,1,0:50') from None
    eye, target = (frame.to_world(np.array(point)).tolist() for point in (eye, target))
    return look_at(eye, target, yfov_degrees=angle[0][0] if angle else 60.0, aspect=aspect)
