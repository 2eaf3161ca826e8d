"""A scene kept on a device: what every kernel reads and every renderer of that scene shares."""

from __future__ import annotations

from copy import copy
from functools import cache, cached_property
from threading import Lock

import numpy as np
import warp as wp

from gpu.core.device import alike, block_of, choose_device, duplicate, overwrite, struct_array, write_changes
from gpu.core.kernel_loading import host_kernels, imported_kernels, load_kernels
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_refit import copied
from gpu.device_scene.data import MaterialData, SceneData, SlotData, TextureData
from gpu.device_scene.environment import upload_environment
from gpu.device_scene.extents import extents_of, renewed, solid_vertices
from gpu.device_scene.features import (
    SceneFeatures,
    features_of_any,
    has_blend,
    has_cutouts,
    has_sheer,
    has_specular,
    scene_features,
    triangle_group,
)
from gpu.device_scene.material_rows import decoded_bytes, material_rows, slot_rows, texture_rows
from gpu.device_scene.moved_tree import MovedTree, TreeFacts, facts_of
from gpu.device_scene.ray_cost import check_ray_cost
from gpu.device_scene.trees import tree_over
from gpu.scene.types import Environment, Floats, Ints, Mask, Scene, same_materials, same_picture

_BOTH = "_with_panes"  # the name of the tree over opaque triangles and panes
_loading = Lock()


def load_scene_kernels(device: str) -> None:
    """Load what scenes on a device take, if nobody has yet, or wait for who does."""
    with _loading:
        _load_side_by_side(device)


@cache
def _load_side_by_side(device: str) -> None:
    chosen, host = wp.get_device(device), wp.get_device("cpu")
    package = __name__.rpartition(".")[0]
    load_kernels(host_kernels(), host, block_of(host))
    load_kernels([*imported_kernels(package), *imported_kernels("gpu.core")], chosen, block_of(chosen))


class DeviceScene:
    """A scene's geometry, materials and textures on one device.

    general: whether renderers of it take it for one that may have everything, so that they launch general kernels;
    constants: as of SceneFeatures.
    `data` is what kernels take; `triangle_order` (triangle,) maps the device's triangles, opaque ones first, then
    panes, then what is there in part, then a backdrop's, to the scene's. Raises DeviceError when `device` does not
    exist, SceneError where so many triangles overlap that rays would take too long.
    """

    general: bool
    constants: bool
    data: SceneData
    _material_rows: np.ndarray

    def __init__(self, scene: Scene, device: str | None = None, lender: DeviceScene | None = None) -> None:
        """lender: one on the same device with another state of the scene; both share what that does not change."""
        self.scene = scene
        self.general = lender is not None and lender.general
        self._features: dict[bool, SceneFeatures] = {}  # by whether surfaces are Lambertian
        # Of trees by name: what the host knows of them, once anything has moved, and what fits them in this state.
        self._tree_facts: dict[str, TreeFacts] = {}
        self._moved: dict[str, MovedTree] = {}
        # Of vertices and triangles, those that other scenes have, too, in the same arrays, with what goes with them.
        self._lent: frozenset[str] = frozenset()
        self.device = choose_device(device)
        self.constants = bool(self.device.is_cuda) if lender is None else lender.constants
        kind = np.array([triangle_group(material) for material in scene.materials])[scene.triangle_material]
        numbers = DEVICE_SHARING.beside(lambda: np.argsort(kind, kind="stable").astype(np.int32))
        self.triangle_order: Ints = numbers
        materials = scene.triangle_material[numbers]
        culled = np.array([material.double_sided is False for material in scene.materials])[materials]

        if lender is None:
            load_scene_kernels(str(self.device))
        data = SceneData()
        data.vertices = self._upload(scene.vertices, wp.vec3)
        data.normals = self._upload(scene.normals, wp.vec3)
        data.uvs = self._upload(scene.uvs, wp.vec2)
        data.has_colors = scene.colors is not None
        data.colors = self._upload(np.ones((1, 4), np.float32) if scene.colors is None else scene.colors, wp.vec4)
        data.triangles = self._upload(scene.triangles[numbers], wp.vec3i)
        data.triangle_material = self._upload(materials, wp.int32)
        self._culled = self._upload(culled.astype(np.float32), wp.float32)
        self.data = data
        self._set_materials(lender)
        if lender is None:
            self._upload_textures(data)
        else:
            for name in ("slots", "textures", "texels", "decode"):
                setattr(data, name, getattr(lender.data, name))
        self._set_sky(lender)
        counts = np.bincount(kind, minlength=4).tolist()
        data.opaque_count, data.pane_count, data.masked_count, data.backdrop_count = counts
        data.alpha, data.textured, data.glossy = data.masked_count > 0, bool(scene.textures), True
        data.transmissive = any(material.transmission > 0.0 for material in scene.materials)
        data.coverage = wp.uint32(1)  # of rays without a seed of their own
        data.one_sided = bool(culled.any())
        for name in self._groups():
            self._make_tree(name)

    def generalised(self, *, general: bool = True) -> DeviceScene:
        """The same scene, in the same arrays, which is `general` or not."""
        other = copy(self)
        other.general = general
        return other

    def as_on_gpus(self) -> DeviceScene:
        """The same scene, in the same arrays, for which kernels are made as for GPUs, wherever it is."""
        other = copy(self)
        other.constants, other._features = True, {}
        return other

    def features(self, *, lambertian: bool, **assumed: bool) -> SceneFeatures:
        """What is told to all kernels that renderers of it launch, and arrays that they allocate: what it has, and what
        is `assumed` of it (scene_features). There are no general kernels for scenes that are taken for Lambertian.
        """
        has = self.own_features(lambertian=lambertian)
        if self.general and not lambertian:
            return features_of_any(has)
        if not any(assumed.values()):
            return has
        return scene_features(self.scene, lambertian=lambertian, constants=self.constants, **assumed)

    def edited(self, scene: Scene, *, in_place: bool = False) -> DeviceScene:
        """`scene`, which is this one with edits (gpu.scene.edits), as it would be if it were put on the device anew.

        Both share textures, and triangles unless there are others, or rays meet a material otherwise than before, as
        glass that becomes rough; and where these are unless something has moved.

        in_place: nobody needs this one any more, so that things may move in its arrays; `settle` then tells whether its
        trees still fit.
        """
        known = self.scene
        same = scene.materials is known.materials
        groups = ([triangle_group(material) for material in one.materials] for one in (scene, known))
        kinds = same or next(groups) == next(groups)
        if scene.triangles is not known.triangles or not kinds:
            return DeviceScene(scene, str(self.device), self)
        other = copy(self)
        other.scene, other.data = scene, duplicate(SceneData, self.data)
        if not in_place:
            other._lent, other._moved = frozenset({"vertices", "triangles"}), {}
        same = same or same_materials(scene.materials, known.materials)
        if not same:
            other._set_materials(self)
        elif not in_place:
            other.data.materials = wp.clone(self.data.materials)
        if not (in_place and scene.sky is known.sky):
            other._set_sky(self)
        if not (same and type(scene.sky) is type(known.sky) and len(scene.lights) == len(known.lights)):
            other._features = {}
        if scene.vertices is not known.vertices or scene.normals is not known.normals:
            other._move(known)
            if not in_place:
                other.settle()
        return other

    def _move(self, known: Scene) -> None:
        """Have things where they are now, in arrays of its own; it has those, and trees, of the state `known`."""
        data, scene = self.data, self.scene
        for name, (tree, begin, end) in self._trees().items():
            if name not in self._tree_facts:
                self._tree_facts[name] = facts_of(data, tree, begin, end, looks=name == "masked")
        if "vertices" in self._lent:
            self._lent -= {"vertices"}
            data.vertices, data.normals = wp.clone(data.vertices), wp.clone(data.normals)
            for name, (tree, _, _) in self._trees().items():
                self._set_tree(name, copied(tree))
        rows = write_changes(data.vertices, known.vertices, scene.vertices)
        write_changes(data.normals, known.normals, scene.normals)
        self._extents = renewed(self._extents, scene.vertices, self._solid, *rows)
        self.__dict__.pop("solid_radius", None)
        for name, (tree, _, _) in self._trees().items():
            facts = self._tree_facts[name]
            if not facts.has_any(*rows):
                continue
            if not facts.holds(scene.vertices):
                self._make_tree(name)
                continue
            if name not in self._moved:
                self._moved[name] = MovedTree(facts, self.device)
            self._moved[name].fit(tree, data)

    def settle(self) -> None:
        """Have new trees where those that were fitted to what has moved cost rays too much."""
        for name, moved in [*self._moved.items()]:
            if moved.is_dear():
                self._make_tree(name)

    def own_features(self, *, lambertian: bool) -> SceneFeatures:
        """What it has (gpu.device_scene.features), looked for once."""
        if lambertian not in self._features:
            self._features[lambertian] = scene_features(self.scene, lambertian=lambertian, constants=self.constants)
        return self._features[lambertian]

    def _groups(self) -> dict[str, tuple[int, int]]:
        """The trees that there are to be, and from where to where their triangles are."""
        data, begin, groups = self.data, 0, {}
        counts = data.opaque_count, data.pane_count, data.masked_count, data.backdrop_count
        for name, count in zip(("opaque", "panes", "masked", "backdrop"), counts, strict=True):
            if count:
                groups[name] = begin, begin + count
            begin += count
        if _BOTH in self.__dict__:
            groups[_BOTH] = 0, data.opaque_count + data.pane_count
        return groups

    def _trees(self) -> dict[str, tuple[Bvh, int, int]]:
        """Those that there are."""
        return {
            name: (self.__dict__[name] if name == _BOTH else getattr(self.data, name), begin, end)
            for name, (begin, end) in self._groups().items()
        }

    def _set_tree(self, name: str, tree: Bvh) -> None:
        setattr(self if name == _BOTH else self.data, name, tree)

    def _make_tree(self, name: str) -> None:
        """Have a new tree in the place of one that may have been fitted."""
        begin, end = self._groups()[name]
        self._moved.pop(name, None)
        self._tree_facts = {one: facts for one, facts in self._tree_facts.items() if one != name}
        self._set_tree(name, self._tree(begin, end, looks=name == "masked"))

    def can_become(self, other: DeviceScene) -> bool:
        """Whether `become` can be called with `other`: it has the same geometry, or as much where this has its own, and
        kernels need to know no more.
        """
        if any(getattr(other.data, name) is not getattr(self.data, name) for name in self._lent):
            return False
        if other.scene.vertices is not self.scene.vertices:
            panes = self.__dict__.get(_BOTH)
            if not (panes is None or alike(Bvh, panes, other._with_panes)):
                return False
        return alike(SceneData, self.data, other.data) and all(
            self.features(lambertian=lambertian) == other.features(lambertian=lambertian)
            for lambertian in (False, True)
        )

    def become(self, other: DeviceScene) -> None:
        """Be `other` from now on, in the arrays that there are, which renderers read."""
        own = {"data": self.data, "_lent": self._lent}
        if _BOTH in self.__dict__:
            own[_BOTH] = self._with_panes
            if other.scene.vertices is not self.scene.vertices:
                overwrite(Bvh, self._with_panes, other._with_panes)
        overwrite(SceneData, self.data, other.data)
        self.__dict__.clear()
        self.__dict__.update({**other.__dict__, **own})

    def _upload_textures(self, data: SceneData) -> None:
        entries, texels = DEVICE_SHARING.beside(lambda: texture_rows(self.scene.textures))
        data.textures = wp.array(entries or [TextureData()], dtype=TextureData, device=self.device)
        data.texels = self._upload(texels, wp.uint32)
        data.decode = self._upload(decoded_bytes(), wp.float32)
        data.slots = struct_array(SlotData, slot_rows(self.scene.materials), self.device)

    def _set_materials(self, known: DeviceScene | None = None) -> None:
        """`known`: a state of the same scene, of which most are the same."""
        data, scene = self.data, self.scene
        units = scene.frame.metres_per_unit * scene.placement.scale
        before = None if known is None else (known.scene.materials, known._material_rows)
        self._material_rows = rows = material_rows(scene.materials, units, before)
        data.materials = struct_array(MaterialData, rows, self.device)
        data.blended, data.sheer, data.cutouts = has_blend(scene), has_sheer(scene), has_cutouts(scene)
        data.specular, data.coated = has_specular(scene), any(material.clearcoat > 0.0 for material in scene.materials)
        data.sheened = any(material.has_sheen for material in scene.materials)
        data.filmed = any(material.has_film for material in scene.materials)
        data.grained = any(material.has_grain for material in scene.materials)
        data.translucent = any(material.is_translucent for material in scene.materials)
        data.dispersive = any(material.is_dispersive for material in scene.materials)
        data.part_glass = any(material.is_part_glass for material in scene.materials)

    def _set_sky(self, known: DeviceScene | None = None) -> None:
        """`known`: a state of the same scene, whose sky may show the same picture."""
        data, sky, color = self.data, self.scene.sky, (0.0, 0.0, 0.0)
        data.has_environment = isinstance(sky, Environment)
        if isinstance(sky, Environment):
            if known is not None and same_picture(known.scene.sky, sky):
                data.environment = known.data.environment
            else:
                data.environment = upload_environment(sky, self.device)
            color = sky.tint
        elif sky is not None:
            color = sky.radiance
        data.sky = wp.array([color], dtype=wp.vec3, device=self.device)

    def _upload(self, values: np.ndarray, dtype: type) -> wp.array:
        array = wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device)
        DEVICE_SHARING.pause()
        return array

    def _tree(self, begin: int, end: int, *, looks: bool = False) -> Bvh:
        """As `tree_over`; SceneError where rays would look at too much."""
        tree = tree_over(self.data, self._culled, begin, end, looks=looks)
        check_ray_cost(self.scene, tree)
        return tree

    @cached_property
    def faces_by_material(self) -> tuple[Ints, ...]:
        """The device's triangles of each material, ascending."""
        materials = self.scene.triangle_material[self.triangle_order]
        ends = np.cumsum(np.bincount(materials, minlength=len(self.scene.materials)))
        return tuple(np.split(np.argsort(materials, kind="stable").astype(np.int32), ends[:-1]))

    @cached_property
    def _solid(self) -> Mask | None:
        return solid_vertices(self.scene)

    @cached_property
    def _extents(self) -> Floats:
        return extents_of(self.scene.vertices, self._solid)

    @cached_property
    def solid_radius(self) -> float:
        """Of the sphere about the origin that holds what light can meet: all but a backdrop."""
        return float(np.linalg.norm(self._extents.max(axis=0)))

    @cached_property
    def _with_panes(self) -> Bvh:
        """A tree over opaque triangles and panes together."""
        self._tree_facts = {one: facts for one, facts in self._tree_facts.items() if one != _BOTH}
        return self._tree(0, self.data.opaque_count + self.data.pane_count)

    def view(self, *, lambertian: bool, assume_alpha: bool = False) -> SceneData:
        """`data` for one renderer: with `lambertian`, as the path-traced references see the scene.

        Then surfaces, panes too, are opaque and Lambertian with their geometric normals, without alpha or normal maps,
        and cameras see both sides of all.
        assume_alpha: rays look for masks even where there are none.
        """
        data = duplicate(SceneData, self.data)
        data.lambertian = data.ignore_alpha = lambertian
        data.one_sided = data.one_sided and not lambertian
        data.transmissive, data.specular = data.transmissive and not lambertian, data.specular and not lambertian
        data.blended, data.sheer = data.blended and not lambertian, data.sheer and not lambertian
        data.translucent = data.translucent and not lambertian
        data.part_glass = (data.part_glass or self.general) and not lambertian
        if lambertian and data.pane_count:
            data.opaque, data.opaque_count, data.pane_count = self._with_panes, data.opaque_count + data.pane_count, 0
        data.alpha = ((data.masked_count > 0 or self.general) and not lambertian) or assume_alpha
        # Kernels for CPUs are told nothing of it.
        data.cutouts = data.alpha and (data.cutouts or self.general or assume_alpha or not self.constants)
        return data
