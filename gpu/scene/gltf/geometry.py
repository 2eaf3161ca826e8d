"""Meshes of a glTF scene as mesh parts in world space, one a primitive and node."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from gpu.scene.assemble import MeshPart
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.hierarchy import PlacedNode
from gpu.scene.gltf.primitives import Primitive, read_primitive
from gpu.scene.gltf.skins import blend, joint_matrices
from gpu.scene.gltf.transforms import instance_matrices
from gpu.scene.gltf.values import Value
from gpu.scene.gltf.variants import with_material
from gpu.scene.transforms import cofactors, placed
from gpu.scene.types import Doubles, Material
from gpu.scene.validate import check_count, slots


@dataclass
class Geometry:
    """Reads the meshes that nodes show. materials: those of the file, then the default; variant: the chosen one."""

    buffers: Buffers
    materials: list[Material]
    variant: int | None = None
    _primitives: dict[tuple[str, tuple[float, ...]], Primitive | None] = field(default_factory=dict)
    _triangles: int = 0
    _vertices: int = 0

    def parts(self, placed: dict[str, PlacedNode]) -> Iterator[MeshPart]:
        """The mesh parts of all nodes. Raises SceneError when a mesh is broken or limits are exceeded."""
        document = self.buffers.document
        for node in placed.values():
            if node.visible and node.entry.has("mesh"):
                mesh = document.attempt(partial(document.referred, node.entry, "mesh", "meshes"), "the mesh")
                if mesh is not None:
                    name = node.entry.name(mesh.name(mesh.path))
                    for part in self._node_parts(node, mesh, self._joints(node, placed)):
                        yield replace(part, object=name)

    def _joints(self, node: PlacedNode, placed: dict[str, PlacedNode]) -> Doubles | None:
        """The matrices of the node's skin; None where it has none that can be used."""
        document = self.buffers.document
        if not node.entry.has("skin"):
            return None

        def read() -> Doubles:
            return joint_matrices(self.buffers, document.referred(node.entry, "skin", "skins"), placed)

        return document.attempt(read, "the skin")

    def _node_parts(self, node: PlacedNode, mesh: Value, joints: Doubles | None) -> Iterator[MeshPart]:
        instancing = node.entry.extension("EXT_mesh_gpu_instancing")
        instances = instance_matrices(self.buffers, instancing) if instancing else np.eye(4)[None]
        primitives = mesh.objects("primitives")
        if not primitives:
            self.buffers.document.ignored.add("has no primitives and was left out", mesh.path)
        for entry in primitives:
            material, primitive = self._material(entry), self._primitive(entry, _weights(node.entry, mesh))
            if primitive is None:
                continue
            self._count(primitive, len(instances))
            blended = None
            if joints is not None:
                blended = self.buffers.document.attempt(partial(blend, primitive, joints, entry), "the skin")
            if blended is None:
                attributes = primitive.attributes
                part = _part(primitive, material, attributes["POSITION"], attributes.get("NORMAL"))
                yield placed(part, node.to_world @ instances)
            else:
                if len(instances) > 1:
                    self.buffers.document.ignored.add("instances of a skinned mesh are shown as one", node.entry.path)
                yield _skinned(primitive, material, blended)

    def _material(self, entry: Value) -> int:
        default = len(self.materials) - 1
        place = with_material(entry, self.variant)
        if not place.has("material"):
            return default
        return place.mended(lambda: place.get("material").as_index(default), default, "glTF's default one was used")

    def _primitive(self, entry: Value, weights: tuple[float, ...]) -> Primitive | None:
        key = (entry.path, weights)
        if key not in self._primitives:
            used = [slot.uv_set for slot in slots(self.materials[self._material(entry)]).values()]
            primitive = read_primitive(self.buffers, entry, max(used, default=-1) + 1, weights)
            missing = {f"TEXCOORD_{uv_set}" for uv_set in used} - primitive.attributes.keys() if primitive else ()
            for name in sorted(missing):
                problem = f"has no {name} for its textures; (0, 0) was used"
                self.buffers.document.notes.add(problem, entry.path)
            self._primitives[key] = primitive
        return self._primitives[key]

    def _count(self, primitive: Primitive, instances: int) -> None:
        """Raise SceneError before memory is taken for more triangles or vertices than allowed."""
        source, limits = str(self.buffers.document.path), self.buffers.document.limits
        self._triangles += instances * len(primitive.triangles)
        self._vertices += instances * len(primitive.attributes["POSITION"])
        check_count(source, "triangles", self._triangles, limits.max_triangles, "max_triangles")
        check_count(source, "vertices", self._vertices, limits.max_vertices, "max_vertices")


def _weights(node: Value, mesh: Value) -> tuple[float, ...]:
    """Weights of the morph targets: the node's own, else the mesh's."""
    place = node if node.has("weights") else mesh
    return tuple(item.as_factor(0.0, -1e6, 1e6) for item in place.parts("weights"))


def _skinned(primitive: Primitive, material: int, matrices: Doubles) -> MeshPart:
    """`primitive` with each vertex under its own of `matrices` (vertex, 4, 4)."""
    normals = primitive.attributes.get("NORMAL")
    world = np.einsum("vij,vj->vi", matrices[:, :3, :3], primitive.attributes["POSITION"]) + matrices[:, :3, 3]
    if normals is not None:
        normals = np.einsum("vij,vj->vi", cofactors(matrices), normals)
    return _part(primitive, material, world, normals)


def _part(primitive: Primitive, material: int, positions: Doubles, normals: Doubles | None) -> MeshPart:
    attributes = primitive.attributes
    sets = 1 + max((int(name[9:]) for name in attributes if name.startswith("TEXCOORD_")), default=-1)
    missing = np.zeros((len(positions), 2))
    uvs = tuple(attributes.get(f"TEXCOORD_{number}", missing) for number in range(sets))
    colors = attributes.get("COLOR_0")
    if colors is not None:
        alpha = np.ones((len(colors), 4))
        alpha[:, : colors.shape[1]] = colors
        colors = alpha
    return MeshPart(positions, primitive.triangles, normals, uvs, colors, material, primitive.path)
