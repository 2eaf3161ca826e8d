"""Meshes of a glTF scene as mesh parts in world space, one a primitive and node."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from gpu.scene.animation.motion import Body, Skin
from gpu.scene.animation.pose import Pose, all_in_world
from gpu.scene.formats.gltf.animations import NOT_MOVED, Moved
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.hierarchy import PlacedNode
from gpu.scene.formats.gltf.primitives import Primitive, read_primitive
from gpu.scene.formats.gltf.skins import bindings, read_skin
from gpu.scene.formats.gltf.tangents import turn_of
from gpu.scene.formats.gltf.transforms import instance_matrices
from gpu.scene.formats.gltf.values import Value
from gpu.scene.formats.gltf.variants import with_material
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Material
from gpu.scene.validate import check_count, slots

_ONE = np.eye(4)[None]


@dataclass
class Geometry:
    """Reads the meshes that nodes show. materials: those of the file, then the default, then those whose grain the
    tangents of meshes turn, as they are found; variant: the chosen one; moved: what animations move.
    """

    buffers: Buffers
    materials: list[Material]
    variant: int | None = None
    moved: Moved = NOT_MOVED
    _primitives: dict[tuple[str, frozenset[int]], Primitive | None] = field(default_factory=dict)
    _used: dict[int, list[int]] = field(default_factory=dict)
    _skins: dict[str, Skin | None] = field(default_factory=dict)
    _turned: dict[tuple[int, float], int] = field(default_factory=dict)
    _turns: dict[tuple[int, str], float] = field(default_factory=dict)
    _triangles: int = 0
    _vertices: int = 0

    def __post_init__(self) -> None:
        self.default = len(self.materials) - 1

    def parts(self, placed: dict[str, PlacedNode]) -> list[MeshPart]:
        """The mesh parts of all nodes. Raises SceneError when a mesh is broken or limits are exceeded."""
        document = self.buffers.document
        pose = Pose(np.stack([node.to_world for node in placed.values()]) if placed else np.zeros((0, 4, 4)))
        found: list[tuple[MeshPart, Body]] = []
        for node in placed.values():
            if node.visible and node.entry.has("mesh"):
                mesh = document.attempt(partial(document.referred, node.entry, "mesh", "meshes"), "the mesh")
                if mesh is not None:
                    name = node.entry.name(mesh.name(mesh.path))
                    for part, body in self._node_parts(node, mesh, name, placed):
                        found.append((replace(part, body=body) if self._moves(body) else part, body))
        return all_in_world(found, pose)

    def _moves(self, body: Body) -> bool:
        nodes = [body.node] if body.skin is None else body.skin.joints.tolist()
        return body.node in self.moved.weights or not self.moved.nodes.isdisjoint(nodes)

    def _skin(self, node: PlacedNode, placed: Mapping[str, PlacedNode]) -> Skin | None:
        """The node's skin; None where it has none that can be used."""
        document = self.buffers.document
        if not node.entry.has("skin"):
            return None
        entry = document.attempt(partial(document.referred, node.entry, "skin", "skins"), "the skin")
        if entry is not None and entry.path not in self._skins:
            self._skins[entry.path] = document.attempt(partial(read_skin, self.buffers, entry, placed), "the skin")
        return None if entry is None else self._skins[entry.path]

    def _node_parts(
        self, node: PlacedNode, mesh: Value, name: str, placed: Mapping[str, PlacedNode]
    ) -> Iterator[tuple[MeshPart, Body]]:
        """The primitives of a node's mesh, each in its own space, as parts of the object of that name."""
        ignored, skin = self.buffers.document.ignored, self._skin(node, placed)
        instancing = node.entry.extension("EXT_mesh_gpu_instancing")
        instances = instance_matrices(self.buffers, instancing) if instancing else _ONE
        primitives = mesh.objects("primitives")
        if not primitives:
            ignored.add("has no primitives and was left out", mesh.path)
        weights = _weights(node.entry, mesh)
        for entry in primitives:
            material, primitive = (
                self._material(entry),
                self._primitive(entry, self._targets(entry, node.number, weights)),
            )
            if primitive is None:
                continue
            self._count(primitive, len(instances))
            part = _part(primitive, self._with_grain(material, primitive), name)
            body = Body(
                node.number, part.positions, part.normals, primitive.triangles, instances, primitive.targets, weights
            )
            if skin is not None:
                bound = self.buffers.document.attempt(partial(bindings, primitive, skin, entry), "the skin")
                if bound is not None:
                    body = replace(body, skin=skin, joints=bound[0], shares=bound[1])
                    if len(instances) > 1:
                        ignored.add("instances of a skinned mesh are shown as one", node.entry.path)
            yield part, body

    def _targets(self, entry: Value, node: int, weights: tuple[float, ...]) -> frozenset[int]:
        """The morph targets of a primitive that are used: all where weights change, else those that have one."""
        if node in self.moved.weights:
            return frozenset(range(len(entry.parts("targets"))))
        return frozenset(number for number, weight in enumerate(weights) if weight != 0.0)

    def _material(self, entry: Value) -> int:
        default = self.default
        place = with_material(entry, self.variant)
        if not place.has("material"):
            return default
        return place.mended(lambda: place.index("material", default), default, "glTF's default one was used")

    def _primitive(self, entry: Value, targets: frozenset[int]) -> Primitive | None:
        key = (entry.path, targets)
        if key not in self._primitives:
            material = self._material(entry)
            used, tangents = self._uv_sets(material), self.materials[material].has_grain
            primitive = read_primitive(self.buffers, entry, max(used, default=-1) + 1, targets, tangents=tangents)
            missing = {f"TEXCOORD_{uv_set}" for uv_set in used} - primitive.attributes.keys() if primitive else ()
            for name in sorted(missing):
                problem = f"has no {name} for its textures; (0, 0) was used"
                self.buffers.document.notes.add(problem, entry.path)
            self._primitives[key] = primitive
        return self._primitives[key]

    def _uv_sets(self, material: int) -> list[int]:
        if material not in self._used:
            look = self.materials[material]
            grain = [look.grain_set] if look.has_grain else []
            self._used[material] = [*(slot.uv_set for slot in slots(look).values()), *grain]
        return self._used[material]

    def _with_grain(self, material: int, primitive: Primitive) -> int:
        """The number of the material whose grain lies as a primitive's tangents tell."""
        look = self.materials[material]
        if not look.has_grain:
            return material
        one = material, primitive.path
        if one not in self._turns:
            self._turns[one], together = turn_of(primitive, look.grain_set)
            if not together:
                problem = "has tangents that turn against its UVs; its anisotropy has their mean direction"
                self.buffers.document.notes.add(problem, primitive.path)
        turn = self._turns[one]
        key = material, round(turn, 3)
        if turn and key not in self._turned:
            self._turned[key] = len(self.materials)
            self.materials.append(replace(look, anisotropy_rotation=look.anisotropy_rotation + turn))
        return self._turned.get(key, material)

    def settled(self, parts: list[MeshPart]) -> tuple[list[MeshPart], dict[int, list[int]]]:
        """`parts`, with the default material left out where none has it, and the numbers of a material's turned ones
        by its own. A material that all its meshes turn becomes the first of them, so that whatever names it finds it.
        """
        used = {part.material for part in parts}
        gone, instead = {self.default} - used, dict[int, int]()
        for (own, _), number in self._turned.items():
            if own not in used:
                used.add(own)
                self.materials[own], instead[number] = self.materials[number], own
        kept = [number for number in range(len(self.materials)) if number not in gone and number not in instead]
        places = {number: place for place, number in enumerate(kept)}
        places |= {number: places[own] for number, own in instead.items()}
        self.materials[:] = [self.materials[number] for number in kept]
        turned = dict[int, list[int]]()
        for (own, _), number in self._turned.items():
            if number not in instead:
                turned.setdefault(own, []).append(places[number])
        moved = any(number != place for number, place in places.items())
        return [replace(part, material=places[part.material]) for part in parts] if moved else parts, turned

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


def _part(primitive: Primitive, material: int, name: str) -> MeshPart:
    attributes = primitive.attributes
    positions = attributes["POSITION"]
    sets = 1 + max((int(name[9:]) for name in attributes if name.startswith("TEXCOORD_")), default=-1)
    missing = np.zeros((len(positions) if sets else 0, 2))
    uvs = tuple(attributes.get(f"TEXCOORD_{number}", missing) for number in range(sets))
    colors = attributes.get("COLOR_0")
    if colors is not None:
        alpha = np.ones((len(colors), 4))
        alpha[:, : colors.shape[1]] = colors
        colors = alpha
    normals = attributes.get("NORMAL")
    return MeshPart(positions, primitive.triangles, normals, uvs, colors, material, primitive.path, (name,))
