"""Meshes of a stage as parts, one a material, before they are placed."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import UsdGeom, UsdShade

from gpu.errors import SceneError
from gpu.scene.formats.usd.materials import Materials
from gpu.scene.formats.usd.primvars import Topology, Values, checked, read_primvar
from gpu.scene.formats.usd.shapes import shape_of
from gpu.scene.formats.usd.stage import Stage
from gpu.scene.geometry.polygons import TOO_LARGE, triangulate
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers
from gpu.scene.validate import check_finite, check_indices


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of a prim with the face each is of: what all its instances share, whatever their materials."""

    topology: Topology
    positions: Doubles
    corners: Integers
    faces: Integers
    normals: Values | None


@dataclass
class Meshes:
    """Reads meshes and shapes; instances of one prototype are read once."""

    stage: Stage
    materials: Materials
    _read: dict[str, Surface] = field(default_factory=dict)

    def parts(self, prim: Any) -> Iterator[MeshPart]:
        """The parts of a mesh or shape, one a material. Raises SceneError when it is broken."""
        key = str(prim.GetPrimInPrototype().GetPath() if prim.IsInstanceProxy() else prim.GetPath())
        if key not in self._read:
            self._read[key] = self._surface(prim)
        surface = self._read[key]
        double_sided = bool(UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self.stage.time))
        for bound, faces in _bindings(self.stage, prim, len(surface.topology.counts)):
            chosen = np.isin(surface.faces, faces) if faces is not None else slice(None)
            if len(surface.corners[chosen]):
                yield self._part(prim, surface, surface.corners[chosen], (bound, double_sided))

    def _surface(self, prim: Any) -> Surface:
        if not prim.IsA(UsdGeom.Mesh):
            made = shape_of(self.stage, prim)
            corners = np.arange(made.triangles.size).reshape(-1, 3)
            topology = Topology(made.triangles.reshape(-1), np.full(len(corners), 3), len(made.positions))
            normals = None if made.normals is None else Values(made.normals, UsdGeom.Tokens.vertex)
            return Surface(topology, made.positions, corners, np.arange(len(corners)), normals)
        return _mesh_surface(self.stage, prim)

    def _part(self, prim: Any, surface: Surface, triangles: Integers, bound: tuple[Any, bool]) -> MeshPart:
        stage, topology = self.stage, surface.topology
        color = read_primvar(stage, prim, "displayColor", topology, 3)
        opacity = read_primvar(stage, prim, "displayOpacity", topology, 1)
        appearance = self.materials.look(*bound, color is not None, opacity is not None)
        uvs = [read_primvar(stage, prim, name, topology, 2) for name in appearance.uv_names]
        if None in uvs:
            stage.remarks.add(
                "a mesh has no texture coordinates for its textures; (0, 0) was used", str(prim.GetPath())
            )
        used = [surface.normals, *uvs, *([color, opacity] if appearance.colored else [])]
        by_corner = surface.normals is None or any(values.by_corner for values in used if values)
        place = topology.corners if not by_corner else np.arange(len(topology.corners))
        kept, compact = np.unique(place[triangles], return_inverse=True)

        def rows(values: Values | None, otherwise: Doubles) -> Doubles:
            return topology.spread(values, by_corner)[kept] if values else np.repeat(otherwise, len(kept), axis=0)

        colors = None
        if appearance.colored and (color or opacity):
            colors = np.concatenate([rows(color, np.ones((1, 3))), rows(opacity, np.ones((1, 1)))], axis=1)
        return MeshPart(
            positions=(surface.positions[topology.corners] if by_corner else surface.positions)[kept],
            triangles=compact.reshape(-1, 3),
            normals=rows(surface.normals, np.zeros((1, 3))) if surface.normals else None,
            # USD's v = 0 is the bottom of a texture, glTF's the top.
            uvs=tuple(rows(uv, np.array([[0.0, 1.0]])) * (1.0, -1.0) + (0.0, 1.0) for uv in uvs),
            colors=colors,
            material=appearance.number,
            name=str(prim.GetPath()),
        )


def _mesh_surface(stage: Stage, prim: Any) -> Surface:
    mesh, source, path = UsdGeom.Mesh(prim), str(stage.path), str(prim.GetPath())
    positions = np.array(mesh.GetPointsAttr().Get(stage.time) or (), np.float64).reshape(-1, 3)
    counts, corners = (
        np.array(attribute.Get(stage.time) or (), np.int64)
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
    )
    check_finite(source, f"{path}.points", positions)
    check_indices(source, f"{path}.faceVertexIndices", corners, len(positions))
    if counts.sum() != len(corners) or (counts < 0).any():
        raise SceneError(source, f"{path}.faceVertexCounts", f"sum up to {counts.sum()}, but {len(corners)} indices")
    topology = Topology(corners, counts, len(positions))
    found = triangulate(positions, corners, counts)
    if found.crossing:
        stage.remarks.add("faces that cross themselves were filled as far as they can be", path)
    if found.too_small:
        stage.remarks.add("faces of fewer than 3 corners were left out", path)
    if found.too_large:
        stage.remarks.add(TOO_LARGE, path)
    shown = ~np.isin(found.polygons, np.array(mesh.GetHoleIndicesAttr().Get(stage.time) or (), np.int64))
    triangles, faces = found.triangles[shown], found.polygons[shown]
    if mesh.GetOrientationAttr().Get(stage.time) == UsdGeom.Tokens.leftHanded:
        triangles = triangles[:, ::-1]
    if mesh.GetSubdivisionSchemeAttr().Get(stage.time) != UsdGeom.Tokens.none:
        stage.remarks.add("subdivision surfaces are shown as their cages", path)
    return Surface(topology, positions, triangles, faces, _normals(stage, mesh, topology))


def _normals(stage: Stage, mesh: Any, topology: Topology) -> Values | None:
    """The mesh's normals: primvars:normals counts before the attribute."""
    found = read_primvar(stage, mesh.GetPrim(), "normals", topology, 3)
    raw = mesh.GetNormalsAttr().Get(stage.time)
    if found or not raw:
        return found
    return checked(stage, mesh.GetPrim(), ("normals", raw, mesh.GetNormalsInterpolation()), topology, 3)


def _bindings(stage: Stage, prim: Any, faces: int) -> Iterator[tuple[Any, Integers | None]]:
    """The material of `prim` and of each of its subsets, with their faces; None stands for all faces."""
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets() if prim.IsA(UsdGeom.Mesh) else []
    rest = np.arange(faces)
    for subset in subsets:
        chosen = np.array(subset.GetIndicesAttr().Get(stage.time) or (), np.int64)
        check_indices(str(stage.path), f"{subset.GetPath()}.indices", chosen, faces)
        chosen = np.intersect1d(chosen, rest)
        rest = np.setdiff1d(rest, chosen)
        yield _bound(subset.GetPrim()), chosen
    if len(rest):
        yield _bound(prim), rest if subsets else None


def _bound(prim: Any) -> Any:
    """The material bound to `prim`, an invalid one if there is none."""
    return UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)[0]
