"""A scene kept on a device: what every kernel reads and every renderer of that scene shares."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import warp as wp

from gpu.core.device import alike, choose_device, duplicate, overwrite, struct_array
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_build import build
from gpu.device_scene.data import NO_TEXTURE, MaterialData, SceneData, SlotData, TextureData
from gpu.device_scene.environment import upload_environment
from gpu.device_scene.features import has_specular, scene_features
from gpu.device_scene.ray_cost import check_ray_cost
from gpu.device_scene.repeated import repeated
from gpu.scene.types import AlphaMode, Environment, Floats, Ints, Mask, Material, Scene, Texture, TextureSlot

_LEAST_TRANSMITTANCE = 1e-6  # of a black attenuation colour, whose absorption would be infinite


def _slot(slot: TextureSlot | None) -> SlotData:
    data = SlotData()
    data.texture = NO_TEXTURE if slot is None else slot.texture
    if slot is not None:
        data.uv_set = slot.uv_set
        data.row_u = wp.vec3(*slot.transform[:3])
        data.row_v = wp.vec3(*slot.transform[3:])
    return data


def _absorption(material: Material, units_per_length: float) -> wp.vec3:
    """Beer's law for the inside of a material [1/unit length] (KHR_materials_volume, Attenuation).

    units_per_length: unit lengths in one of the file's.
    """
    colour = np.maximum(material.attenuation_color, _LEAST_TRANSMITTANCE)
    return wp.vec3(*(-np.log(colour) / (material.attenuation_distance * units_per_length)))


def _material(material: Material, units_per_length: float) -> MaterialData:
    data = MaterialData()
    data.base_color = wp.vec4(*material.base_color)
    data.emission = wp.vec3(*material.emission)
    data.metallic, data.roughness, data.ior = material.metallic, material.roughness, material.ior
    data.specular, data.specular_color = material.specular, wp.vec3(*material.specular_color)
    data.transmission, data.normal_scale, data.unlit = material.transmission, material.normal_scale, material.unlit
    data.thin = material.thickness == 0.0
    data.absorption = _absorption(material, units_per_length)
    data.alpha_cutoff, data.blend = material.solid_alpha, material.alpha_mode is AlphaMode.BLEND
    data.double_sided = bool(material.double_sided)
    data.base_color_slot = _slot(material.base_color_slot)
    data.metallic_roughness_slot = _slot(material.metallic_roughness_slot)
    data.normal_slot = _slot(material.normal_slot)
    data.emission_slot = _slot(material.emission_slot)
    data.transmission_slot = _slot(material.transmission_slot)
    data.coat, data.coat_roughness = material.clearcoat, material.clearcoat_roughness
    data.coat_slot, data.coat_roughness_slot = _slot(material.clearcoat_slot), _slot(material.clearcoat_roughness_slot)
    return data


def _kind(material: Material) -> int:
    """The group of triangles that those of `material` are in, by SceneData's order."""
    if material.backdrop:
        return 3
    if material.alpha_mode is not AlphaMode.OPAQUE:
        return 2
    return int(material.is_clear)


def _textures(textures: tuple[Texture, ...]) -> tuple[list[TextureData], np.ndarray]:
    """The textures' descriptions, and all their texels one behind the other; equal images are stored once."""
    places: dict[int, int] = {}
    chunks: list[np.ndarray] = []
    total = 0
    entries = []
    for texture in textures:
        if id(texture.pixels) not in places:
            places[id(texture.pixels)] = total
            chunks.append(np.ascontiguousarray(texture.pixels).view("<u4").ravel())
            total += chunks[-1].size
        entry = TextureData()
        entry.first = places[id(texture.pixels)]
        entry.height, entry.width = texture.pixels.shape[:2]
        entry.srgb, entry.nearest = texture.srgb, texture.nearest
        entry.wrap_s, entry.wrap_t = int(texture.wrap_s), int(texture.wrap_t)
        entries.append(entry)
    return entries, np.concatenate(chunks) if chunks else np.zeros(1, np.uint32)


def _corner_values(scene: Scene) -> Floats:
    """All that vertices have but their normals, (vertex, value)."""
    return np.concatenate([scene.vertices, *scene.uvs, *([] if scene.colors is None else [scene.colors])], axis=1)


def _srgb_decode() -> np.ndarray:
    """Linear value of each sRGB byte, shape (256,) (IEC 61966-2-1)."""
    encoded = np.arange(256) / 255.0
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)


@dataclass(frozen=True)
class _Order:
    """A scene's triangles (triangle, 3) in the device's order, their materials, and which cameras see from both sides
    not (1) or do (0), (triangle,).
    """

    triangles: Ints
    materials: Ints
    culled: Floats


class DeviceScene:
    """A scene's geometry, materials and textures on one device.

    `data` is what kernels take; `triangle_order` (triangle,) maps the device's triangles, opaque ones first, then
    panes, then masked ones, then a backdrop's, to the scene's. Raises DeviceError when `device` does not exist,
    SceneError where so many triangles overlap that rays would take too long.
    """

    data: SceneData
    _material_rows: np.ndarray

    def __init__(self, scene: Scene, device: str | None = None, lender: DeviceScene | None = None) -> None:
        """lender: one on the same device and with the same textures, which both share then."""
        self.scene = scene
        self._lent = False  # whether other scenes have its geometry, too, in the same arrays
        self.device = choose_device(device)
        kind = np.array([_kind(material) for material in scene.materials])[scene.triangle_material]
        numbers = DEVICE_SHARING.beside(lambda: np.argsort(kind, kind="stable").astype(np.int32))
        self.triangle_order: Ints = numbers
        ordered = self._ordered()
        counts = np.bincount(kind, minlength=4).tolist()

        data = SceneData()
        data.vertices = self._upload(scene.vertices, wp.vec3)
        data.normals = self._upload(scene.normals, wp.vec3)
        data.uvs = self._upload(scene.uvs, wp.vec2)
        data.has_colors = scene.colors is not None
        data.colors = self._upload(np.ones((1, 4), np.float32) if scene.colors is None else scene.colors, wp.vec4)
        data.triangles = self._upload(ordered.triangles, wp.vec3i)
        data.triangle_material = self._upload(ordered.materials, wp.int32)
        self._set_materials(data)
        if lender is None:
            self._upload_textures(data)
        else:
            data.textures, data.texels, data.decode = lender.data.textures, lender.data.texels, lender.data.decode
        self._set_sky(data, lender)
        data.opaque_count, data.pane_count, data.masked_count, data.backdrop_count = counts
        data.alpha, data.textured, data.glossy = data.masked_count > 0, bool(scene.textures), True
        data.transmissive = any(material.transmission > 0.0 for material in scene.materials)
        data.one_sided = bool(ordered.culled.any())
        self.data, begin = data, 0
        for name, count in zip(("opaque", "panes", "masked", "backdrop"), counts, strict=True):
            if count:
                # Where alpha cuts holes, what looks different is different.
                values = _corner_values(scene) if name == "masked" else scene.vertices
                setattr(data, name, self._tree(ordered, values, begin, begin + count))
            begin += count

    def edited(self, scene: Scene) -> DeviceScene:
        """`scene`, which is this one with edits (gpu.scene.edits), as it would be if it were put on the device anew.

        Both share textures, and geometry unless that has changed, or rays meet a material otherwise than before, as
        glass that becomes rough.
        """
        known = self.scene
        same = scene.vertices is known.vertices and scene.triangles is known.triangles
        if not same or [_kind(it) for it in scene.materials] != [_kind(it) for it in known.materials]:
            return DeviceScene(scene, str(self.device), self)
        other = copy(self)
        other._lent = True
        other.scene, other.data = scene, duplicate(SceneData, self.data)
        other._set_materials(other.data, self)
        other._set_sky(other.data, self)
        return other

    def can_become(self, other: DeviceScene) -> bool:
        """Whether `become` can be called with `other`: it has the same geometry, or as much where this has its own, and
        kernels need to know no more.
        """
        if other.data.vertices is not self.data.vertices:
            panes = self.__dict__.get("_with_panes")
            if self._lent or not (panes is None or alike(Bvh, panes, other._with_panes)):
                return False
        return alike(SceneData, self.data, other.data) and all(
            scene_features(self.scene, lambertian=lambertian) == scene_features(other.scene, lambertian=lambertian)
            for lambertian in (False, True)
        )

    def become(self, other: DeviceScene) -> None:
        """Be `other` from now on, in the arrays that there are, which renderers read."""
        own = {"data": self.data, "_lent": self._lent}
        if "_with_panes" in self.__dict__:
            own["_with_panes"] = self._with_panes
            if other.data.vertices is not self.data.vertices:
                overwrite(Bvh, self._with_panes, other._with_panes)
        overwrite(SceneData, self.data, other.data)
        self.__dict__.clear()
        self.__dict__.update({**other.__dict__, **own})

    def _upload_textures(self, data: SceneData) -> None:
        entries, texels = DEVICE_SHARING.beside(lambda: _textures(self.scene.textures))
        data.textures = wp.array(entries or [TextureData()], dtype=TextureData, device=self.device)
        data.texels = self._upload(texels, wp.uint32)
        data.decode = self._upload(_srgb_decode(), wp.float32)

    def _set_materials(self, data: SceneData, known: DeviceScene | None = None) -> None:
        """`known`: a state of the same scene, of which most are the same."""
        units, materials = self.scene.frame.metres_per_unit * self.scene.placement.scale, self.scene.materials
        changed = [*range(len(materials))]
        if known is not None:
            changed = [index for index in changed if materials[index] is not known.scene.materials[index]]
        if known is not None and not changed:
            data.materials = wp.clone(known.data.materials)
            return
        made = wp.array([_material(materials[index], units) for index in changed], dtype=MaterialData, device="cpu")
        rows = made.numpy()
        if known is not None:
            rows = known._material_rows.copy()
            rows[changed] = made.numpy()
        self._material_rows = rows
        data.materials = struct_array(MaterialData, rows, self.device)
        data.specular = has_specular(self.scene)

    def _set_sky(self, data: SceneData, known: DeviceScene | None = None) -> None:
        """`known`: a state of the same scene, whose sky shows the same picture, if any."""
        sky, color = self.scene.sky, (0.0, 0.0, 0.0)
        data.has_environment = isinstance(sky, Environment)
        if isinstance(sky, Environment):
            data.environment = known.data.environment if known else upload_environment(sky, self.device)
            color = sky.tint
        elif sky is not None:
            color = sky.radiance
        data.sky = wp.array([color], dtype=wp.vec3, device=self.device)

    def _upload(self, values: np.ndarray, dtype: type) -> wp.array:
        array = wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device)
        DEVICE_SHARING.pause()
        return array

    def _ordered(self) -> _Order:
        scene, numbers = self.scene, self.triangle_order
        materials = scene.triangle_material[numbers]
        one_sided = np.array([material.double_sided is False for material in scene.materials])[materials]
        return _Order(np.ascontiguousarray(scene.triangles[numbers]), materials, one_sided.astype(np.float32))

    def _tree(self, order: _Order, values: Floats, begin: int, end: int) -> Bvh:
        """A tree over the triangles from `begin` to `end` but repeated ones, which have the same `values` (vertex,
        value), numbered from `begin`.
        """
        part = slice(begin, end)
        again = DEVICE_SHARING.beside(lambda: repeated(values, order.triangles[part], order.materials[part]))
        listed: Mask = ~again
        indices = self._upload(order.triangles[part][listed].ravel(), wp.int32)
        tree = build(self.data.vertices, indices, self._upload(order.culled[part][listed], wp.float32))
        check_ray_cost(self.scene, tree)
        if not listed.all():
            tree.faces = self._upload(np.flatnonzero(listed)[tree.faces.numpy()], wp.int32)
        return tree

    @cached_property
    def faces_by_material(self) -> tuple[Ints, ...]:
        """The device's triangles of each material, ascending."""
        materials = self.scene.triangle_material[self.triangle_order]
        ends = np.cumsum(np.bincount(materials, minlength=len(self.scene.materials)))
        return tuple(np.split(np.argsort(materials, kind="stable").astype(np.int32), ends[:-1]))

    @cached_property
    def solid_radius(self) -> float:
        """Of the sphere about the origin that holds what light can meet: all but a backdrop."""
        vertices, backdrop = self.scene.vertices, np.array([material.backdrop for material in self.scene.materials])
        if backdrop.any():
            vertices = vertices[self.scene.triangles[~backdrop[self.scene.triangle_material]].reshape(-1)]
        return float(np.linalg.norm(np.abs(vertices).max(axis=0)))

    @cached_property
    def _with_panes(self) -> Bvh:
        """A tree over opaque triangles and panes together."""
        return self._tree(self._ordered(), self.scene.vertices, 0, self.data.opaque_count + self.data.pane_count)

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
        if lambertian and data.pane_count:
            data.opaque, data.opaque_count, data.pane_count = self._with_panes, data.opaque_count + data.pane_count, 0
        data.alpha = (data.masked_count > 0 and not lambertian) or assume_alpha
        return data
