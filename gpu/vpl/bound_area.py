"""The areas that bound what VPLs send: A of 1/(π·d² + A), by how densely VPLs lie on a surface.

They are read from one light set for all others. So they tell nothing of where the VPLs of another set lie by chance, by
which the mean over sets would be wrong.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import cells_per_unit
from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.vpl.radiosity_cache import RadiosityCache, vpl_around
from gpu.vpl.radiosity_estimate import NEIGHBOURS
from gpu.vpl.vpl_clusters import VplClusters

# Below a cell of the lowest level, so that cells of that are searched first.
ALMOST = wp.constant(0.99)


@wp.struct
@dataclass
class BoundAreaParameters:
    """vpl_areas: A of a VPL is so many times the surface that there is for each VPL around; unlit: A where there are
    none, unit space squared.
    """

    vpl_areas: float = 2.0
    unlit: float = 1.0e-4


BOUND_AREA_PARAMETERS: BoundAreaParameters = parameters(BoundAreaParameters)


@wp.struct
class BoundAreas:
    """What A is read from: lit: a light set's radiosity, whose disks tell how densely VPLs lie; chosen: how."""

    lit: RadiosityCache
    chosen: BoundAreaParameters


def bound_areas(lit: RadiosityCache, chosen: BoundAreaParameters = BOUND_AREA_PARAMETERS) -> BoundAreas:
    """Both as kernels take them."""
    bounds = BoundAreas()
    bounds.lit, bounds.chosen = lit, chosen
    return bounds


@wp.func
def bound_area(bounds: BoundAreas, position: wp.vec3, normal: wp.vec3) -> float:
    """A of a surface point that is or might be a VPL, unit space squared."""
    lit = bounds.lit
    cell = ALMOST / (cells_per_unit(lit.lowest[0]) * lit.alike.cell_per_spacing)
    vpl = vpl_around(lit, position, normal, cell)
    if vpl < 0:
        return bounds.chosen.unlit
    radius = lit.radius[vpl]
    return bounds.chosen.vpl_areas * PI * radius * radius / float(wp.static(NEIGHBOURS))


@wp.kernel
def bound_area_kernel(first: int, bounds: BoundAreas, vpls: VplClusters, areas: wp.array[float]) -> None:
    """One thread a VPL: its A, areas (vpl,)."""
    vpl = first + wp.tid()
    areas[vpl] = bound_area(bounds, vpls.members.position[vpl], vpls.members.normal[vpl])


def areas_of(vpls: VplClusters, bounds: BoundAreas) -> wp.array:
    """A of each member of `vpls`, (vpl,), unit space squared."""
    count, device = vpls.members.count, vpls.members.flux.device
    areas = wp.zeros(count, dtype=float, device=device)
    launch(bound_area_kernel, count, [bounds, vpls, areas], device)
    return areas
