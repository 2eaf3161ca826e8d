"""Cameras of a stage."""

from typing import Any

from pxr import UsdGeom

from gpu.scene.formats.usd.hierarchy import PlacedPrim
from gpu.scene.formats.usd.stage import Stage
from gpu.scene.transforms import rigid
from gpu.scene.types import Camera

_TENTH = 0.1  # apertures of orthographic cameras are in tenths of a unit


def read_camera(stage: Stage, placed: PlacedPrim) -> Camera | None:
    """The camera at a prim, in the file's coordinates; None, and said, if it has no extent."""
    camera, path = UsdGeom.Camera(placed.prim), str(placed.prim.GetPath())

    def number(attribute: Any) -> float:
        return float(attribute.Get(stage.time))

    width, height = number(camera.GetHorizontalApertureAttr()), number(camera.GetVerticalApertureAttr())
    length = number(camera.GetFocalLengthAttr())
    orthographic = camera.GetProjectionAttr().Get(stage.time) == UsdGeom.Tokens.orthographic
    if not (width > 0.0 and height > 0.0 and (orthographic or length > 0.0)):
        stage.remarks.add("a camera without aperture or focal length was left out", path)
        return None
    if number(camera.GetHorizontalApertureOffsetAttr()) or number(camera.GetVerticalApertureOffsetAttr()):
        stage.remarks.add("shifted apertures of cameras are not shown", path)
    half_height = height / 2.0 * _TENTH if orthographic else height / (2.0 * length)
    return Camera(placed.prim.GetName(), rigid(placed.to_world[0]), half_height, width / height, orthographic)
