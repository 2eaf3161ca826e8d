"""Values on a mesh: one for all of it, or one a face, point or corner."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import UsdGeom

from gpu.scene.formats.usd.stage import Stage
from gpu.scene.types import Doubles, Integers

_BY_POINT = (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying)


@dataclass(frozen=True, eq=False)
class Values:
    """rows (value, component) and what each is of: a token of UsdGeom's interpolation."""

    rows: Doubles
    interpolation: str

    @property
    def by_corner(self) -> bool:
        """Whether the values of a point can differ from face to face."""
        return self.interpolation in (UsdGeom.Tokens.uniform, UsdGeom.Tokens.faceVarying)


@dataclass(frozen=True, eq=False)
class Topology:
    """Polygons. corners (corner,): each corner's point; counts (face,): corners of each face; points: how many."""

    corners: Integers
    counts: Integers
    points: int

    def fits(self, values: Values) -> bool:
        """Whether there are as many values as there should be."""
        expected = {UsdGeom.Tokens.uniform: len(self.counts), UsdGeom.Tokens.faceVarying: len(self.corners)}
        expected |= dict.fromkeys(_BY_POINT, self.points)
        return len(values.rows) == expected.get(values.interpolation, max(len(values.rows), 1))

    def spread(self, values: Values, by_corner: bool) -> Doubles:
        """The values of each corner (corner, component), or of each point where all its corners have the same."""
        rows, kind = values.rows, values.interpolation
        if kind in _BY_POINT:
            return rows[self.corners] if by_corner else rows
        if kind == UsdGeom.Tokens.uniform:
            return np.repeat(rows, self.counts, axis=0)
        if kind == UsdGeom.Tokens.faceVarying:
            return rows
        return np.repeat(rows[:1], len(self.corners) if by_corner else self.points, axis=0)


def read_primvar(stage: Stage, prim: Any, name: str, topology: Topology, components: int) -> Values | None:
    """The primvar `name` of `prim`, or what it inherits; None where it has none, and said, where it does not fit."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    if not primvar or not primvar.HasValue():
        return None
    found = primvar.ComputeFlattened(stage.time)
    return checked(stage, prim, (name, found, primvar.GetInterpolation()), topology, components)


def checked(stage: Stage, prim: Any, found: tuple[str, Any, str], topology: Topology, components: int) -> Values | None:
    """The name, values and interpolation `found` on `prim` as Values; None, and said, where they do not fit."""
    name, raw, interpolation = found
    try:
        rows = np.array(raw if raw is not None else (), np.float64)
        rows = rows.reshape(-1, 1) if components == 1 else rows
    except (TypeError, ValueError):  # of another type
        rows = np.empty((0, 0))
    values = Values(rows, interpolation)
    if rows.ndim == 2 and rows.shape[1] == components and topology.fits(values) and np.isfinite(rows).all():
        return values
    stage.remarks.add(f"values of {name} that do not fit their mesh were left out", str(prim.GetPath()))
    return None
