"""The prims of a stage that are shown, with their matrices: instances, native and of PointInstancers, each counted."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from gpu.errors import SceneError
from gpu.scene.formats.usd.stage import Stage
from gpu.scene.types import Doubles
from gpu.scene.validate import check_count

_HIDDEN = (UsdGeom.Tokens.guide, UsdGeom.Tokens.proxy)
_MAX_NESTING = 16


@dataclass(frozen=True, eq=False)
class PlacedPrim:
    """A prim and its matrices (instance, 4, 4) to the file's world."""

    prim: Any
    to_world: Doubles


def shown_prims(stage: Stage) -> Iterator[PlacedPrim]:
    """All prims that are visible and no guides or proxies. Raises SceneError for too many instances."""
    waiting = [(stage.usd.GetPseudoRoot(), np.eye(4)[None], 0)]
    while waiting:
        prim, above, nesting = waiting.pop()
        imageable = UsdGeom.Imageable(prim)
        if imageable and imageable.GetVisibilityAttr().Get(stage.time) == UsdGeom.Tokens.invisible:
            stage.remarks.add("invisible prims were left out", str(prim.GetPath()))
            continue
        to_world = _placed(stage, prim, above)
        if imageable and imageable.ComputePurpose() in _HIDDEN:
            if prim.IsA(UsdGeom.Boundable):
                stage.remarks.add("guides and proxies were left out", str(prim.GetPath()))
        elif prim.IsA(UsdGeom.PointInstancer):
            waiting += _instances(stage, prim, to_world, nesting)
            continue
        else:
            yield PlacedPrim(prim, to_world)
        children = prim.GetFilteredChildren(Usd.TraverseInstanceProxies())
        waiting += [(child, to_world, nesting) for child in reversed(children)]


def column_matrices(matrices: Any) -> Doubles:
    """USD's row-vector matrices (…, 4, 4) as column-vector ones."""
    return np.asarray(np.array(matrices, np.float64).swapaxes(-1, -2))


def _placed(stage: Stage, prim: Any, above: Doubles) -> Doubles:
    """The matrices of `prim` under those `above` it. Raises SceneError when they are not finite."""
    xformable = UsdGeom.Xformable(prim)
    if not xformable:
        return above
    base = np.eye(4)[None] if xformable.GetResetXformStack() else above
    to_world = base @ column_matrices(xformable.GetLocalTransformation(stage.time))
    if not np.isfinite(to_world).all():
        raise SceneError(str(stage.path), str(prim.GetPath()), "its transform to the world is not finite")
    return np.asarray(to_world)


def _instances(stage: Stage, prim: Any, to_world: Doubles, nesting: int) -> Iterator[tuple[Any, Doubles, int]]:
    """The prototypes of the PointInstancer `prim`, each with the matrices of its instances."""
    source, field = str(stage.path), str(prim.GetPath())
    if nesting == _MAX_NESTING:
        raise SceneError(source, field, f"PointInstancers are nested more than {_MAX_NESTING} deep")
    instancer, time = UsdGeom.PointInstancer(prim), stage.time
    numbers = np.array(instancer.GetProtoIndicesAttr().Get(time) or (), np.int64)
    matrices = instancer.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    if len(matrices) != len(numbers):
        raise SceneError(source, field, f"{len(numbers)} protoIndices, but transforms of {len(matrices)} instances")
    check_count(source, "instances", len(to_world) * len(numbers), stage.limits.max_triangles, "max_triangles")
    shown = np.array(instancer.ComputeMaskAtTime(time) or np.ones(len(numbers)), bool)
    prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < len(prototypes):
        raise SceneError(source, f"{field}.protoIndices", f"names a prototype beyond the {len(prototypes)}")
    local = column_matrices(matrices).reshape(-1, 4, 4)
    for number, path in enumerate(prototypes):
        prototype = stage.usd.GetPrimAtPath(path)
        chosen = local[shown & (numbers == number)]
        if prototype and len(chosen):
            yield prototype, (to_world[:, None] @ chosen).reshape(-1, 4, 4), nesting + 1
