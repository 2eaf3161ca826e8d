"""What a loader returns: one scene as plain NumPy arrays and frozen dataclasses, before any device sees it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.animation.motion import Body, Motion
from gpu.scene.file_frame import FileFrame

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]
Ints = NDArray[np.int32]
Integers = NDArray[np.signedinteger[Any]]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Rgb = tuple[float, float, float]

CLEAR_ROUGHNESS = 0.1
"""Up to this glass is clear: what is seen through it is sharp."""


class Wrap(IntEnum):
    """What a texture shows outside [0, 1]."""

    REPEAT = 0
    CLAMP = 1
    MIRROR = 2


class AlphaMode(IntEnum):
    """How a material's alpha is read; BLEND is coverage: the share of a surface that is there."""

    OPAQUE = 0
    MASK = 1
    BLEND = 2


class LightKind(IntEnum):
    """Kinds of light that are not surfaces."""

    POINT = 0
    SPOT = 1
    DIRECTIONAL = 2


@dataclass(frozen=True)
class Texture:
    """An image with its sampler. pixels: (height, width, 4) uint8; row 0 is v = 0 (glTF); srgb: colours are encoded."""

    name: str
    pixels: Bytes
    srgb: bool
    wrap_s: Wrap = Wrap.REPEAT
    wrap_t: Wrap = Wrap.REPEAT
    nearest: bool = False

    @cached_property
    def least_alpha(self) -> float:
        """The least alpha that it has anywhere."""
        return float(self.pixels[..., 3].min(initial=255)) / 255.0


@dataclass(frozen=True)
class TextureSlot:
    """One use of a texture: which, which UV set, and the 2×3 matrix that maps (u, v, 1) to the texture's own (u, v)."""

    texture: int
    uv_set: int = 0
    transform: tuple[float, float, float, float, float, float] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Material:
    """A glTF metallic-roughness material. Colours are linear Rec. 709; emission is radiance [W/m²/sr].

    double_sided: whether both sides are seen and emit, or the front alone; None where a format does not tell: both are
    seen, and the front emits. iridescence_least, iridescence_most: thickness of its film [nm]. anisotropy_rotation:
    [rad]. backdrop: its triangles are a sky around the scene, seen behind everything; they neither stop nor reflect
    light. stays_light: it is among the lights even where an edit leaves it no emission. path_color: the emission that
    light paths are drawn by (gpu.scene.lighting.path_light), None: its own.
    """

    name: str = "default"
    base_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    metallic: float = 0.0
    roughness: float = 1.0
    emission: Rgb = (0.0, 0.0, 0.0)
    base_color_slot: TextureSlot | None = None
    metallic_roughness_slot: TextureSlot | None = None
    normal_slot: TextureSlot | None = None
    emission_slot: TextureSlot | None = None
    transmission_slot: TextureSlot | None = None
    normal_scale: float = 1.0
    alpha_mode: AlphaMode = AlphaMode.OPAQUE
    alpha_cutoff: float = 0.5
    double_sided: bool | None = None
    unlit: bool = False
    backdrop: bool = False
    transmission: float = 0.0
    ior: float = 1.5
    dispersion: float = 0.0
    thickness: float = 0.0
    attenuation_color: Rgb = (1.0, 1.0, 1.0)
    attenuation_distance: float = inf
    specular: float = 1.0
    specular_color: Rgb = (1.0, 1.0, 1.0)
    specular_slot: TextureSlot | None = None
    specular_color_slot: TextureSlot | None = None
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.0
    clearcoat_slot: TextureSlot | None = None
    clearcoat_roughness_slot: TextureSlot | None = None
    clearcoat_normal_slot: TextureSlot | None = None
    clearcoat_normal_scale: float = 1.0
    sheen_color: Rgb = (0.0, 0.0, 0.0)
    sheen_roughness: float = 0.0
    sheen_color_slot: TextureSlot | None = None
    sheen_roughness_slot: TextureSlot | None = None
    iridescence: float = 0.0
    iridescence_ior: float = 1.3
    iridescence_least: float = 100.0
    iridescence_most: float = 400.0
    iridescence_slot: TextureSlot | None = None
    iridescence_thickness_slot: TextureSlot | None = None
    anisotropy: float = 0.0
    anisotropy_rotation: float = 0.0
    anisotropy_slot: TextureSlot | None = None
    diffuse_transmission: float = 0.0
    diffuse_transmission_color: Rgb = (1.0, 1.0, 1.0)
    diffuse_transmission_slot: TextureSlot | None = None
    diffuse_transmission_color_slot: TextureSlot | None = None
    stays_light: bool = field(default=False, compare=False)
    path_color: Rgb | None = field(default=None, compare=False, repr=False)

    @property
    def emits(self) -> bool:
        """Whether its surfaces are lights, where alpha leaves them; unlit ones are merely shown."""
        return (max(self.emission) > 0.0 or self.stays_light) and not self.unlit

    @property
    def solid_alpha(self) -> float:
        """The alpha from which on there is something, where there is less nothing."""
        return {AlphaMode.OPAQUE: 0.0, AlphaMode.MASK: self.alpha_cutoff, AlphaMode.BLEND: 0.5}[self.alpha_mode]

    @property
    def has_sheen(self) -> bool:
        """Whether fibres on its surfaces reflect something."""
        return max(self.sheen_color) > 0.0 and not self.unlit

    @property
    def has_film(self) -> bool:
        """Whether there is a thin film on its surfaces that has colours."""
        return self.iridescence > 0.0 and not self.unlit

    @property
    def has_grain(self) -> bool:
        """Whether its highlights are longer in one direction than in others."""
        return self.anisotropy > 0.0 and not self.unlit

    @property
    def is_dispersive(self) -> bool:
        """Whether its surfaces are faces of bodies of glass that refract each colour otherwise."""
        return min(self.dispersion, self.glass_share, self.thickness) > 0.0 and not self.unlit

    @property
    def is_translucent(self) -> bool:
        """Whether its surfaces scatter light to their other side."""
        lets_through = self.diffuse_transmission > 0.0 and max(self.diffuse_transmission_color) > 0.0
        return lets_through and not self.unlit

    @property
    def absorbs(self) -> bool:
        """Whether light that goes through it loses something on its way."""
        return self.thickness > 0.0 and self.attenuation_distance < inf and min(self.attenuation_color) < 1.0

    @property
    def grain_set(self) -> int:
        """The UV set that tells the directions of its grain: that of its normal map, else of the grain's own, or 0."""
        slot = self.normal_slot or self.anisotropy_slot
        return 0 if slot is None else slot.uv_set

    @property
    def is_part_glass(self) -> bool:
        """Whether its surfaces are sheets of clear glass, in part or whole, which light crosses straight by a share."""
        clear = self.glass_share > 0.0 and self.roughness <= CLEAR_ROUGHNESS and self.thickness == 0.0
        return clear and not (self.unlit or self.backdrop)

    @property
    def glass_share(self) -> float:
        """The share of its surfaces that is glass, where no texture or alpha leaves less."""
        return self.transmission * (1.0 - self.metallic)

    @property
    def is_clear(self) -> bool:
        """Whether its surfaces are of clear glass, mostly, which light can cross straight."""
        clear = self.glass_share >= 0.5 and self.roughness <= CLEAR_ROUGHNESS
        return clear and self.alpha_mode is AlphaMode.OPAQUE and not self.unlit


def same_materials(some: Sequence[Material], others: Sequence[Material]) -> bool:
    """Whether materials of two states of a scene are the same in all that edits change."""
    return all(
        a is b or (a == b and (a.stays_light, a.path_color) == (b.stays_light, b.path_color))
        for a, b in zip(some, others, strict=True)
    )


def same_emission(some: Sequence[Material], others: Sequence[Material]) -> bool:
    """Whether materials of two states of a scene differ in nothing but what edits change of opaque surfaces beside
    emission.
    """

    def matt(material: Material) -> Material:
        return replace(material, base_color=(0.0, 0.0, 0.0, material.base_color[3]), roughness=1.0, metallic=0.0)

    pairs = [(a, b) for a, b in zip(some, others, strict=True) if a is not b]
    return same_materials([matt(a) for a, _ in pairs], [matt(b) for _, b in pairs])


@dataclass(frozen=True)
class Light:
    """A punctual light in unit space. intensity: [W/sr] in unit space (point, spot) or irradiance [W/m²] (directional).

    position: unit space; direction: where the light goes, unit length; cones: cosines of the half angles (spot).
    path_color: the intensity that light paths are drawn by (gpu.scene.lighting.path_light), None: its own.
    """

    name: str
    kind: LightKind
    intensity: Rgb
    position: Rgb = (0.0, 0.0, 0.0)
    direction: Rgb = (0.0, 0.0, -1.0)
    cos_inner: float = 1.0
    cos_outer: float = 0.0
    path_color: Rgb | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Sky:
    """Light from all around: radiance · (1 + ω·up) / 2 for direction ω, so that it is brightest above, black below.

    path_color: the radiance that light paths are drawn by (gpu.scene.lighting.path_light), None: its own.
    """

    radiance: Rgb
    path_color: Rgb | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, eq=False)
class Environment:
    """Light from all around by an equirectangular picture, pixels (height, width, 3), of which the linear radiance is
    `tint` times as much.

    Its top is towards +Y, its middle towards +Z, a quarter from the left towards +X, before it is turned by the share
    `turn` of a full turn, counter-clockwise from above. path_color: the tint that light paths are drawn by
    (gpu.scene.lighting.path_light), None: its own.
    """

    name: str
    pixels: Floats
    turn: float = 0.0
    tint: Rgb = (1.0, 1.0, 1.0)
    path_color: Rgb | None = field(default=None, compare=False, repr=False)


def same_picture(one: Sky | Environment | None, other: Sky | Environment | None) -> bool:
    """Whether both skies show the same picture, or neither shows one, whatever tints it."""
    pictures = (sky.pixels if isinstance(sky, Environment) else None for sky in (one, other))
    return next(pictures) is next(pictures)


def same_sky(one: Sky | Environment | None, other: Sky | Environment | None) -> bool:
    """Whether both skies shine alike, or there is none."""
    if isinstance(one, Environment) and isinstance(other, Environment):
        return one.tint == other.tint and same_picture(one, other)
    return one == other


@dataclass(frozen=True)
class Camera:
    """A view in world space. to_world: 4×4 column-vector matrix, looking along −Z with +Y up.

    half_height: tan(vertical field of view / 2), or half the view's height [m] when orthographic; near: what is less
    far in front of the camera is cut away from the view [m].
    """

    name: str
    to_world: Doubles
    half_height: float
    aspect: float = 16.0 / 9.0
    orthographic: bool = False
    near: float = 0.0

    @property
    def view_key(self) -> tuple[bytes, float, bool, float]:
        """All of the camera that an image depends on: not the aspect, since an image has its own."""
        return self.to_world.tobytes(), self.half_height, self.orthographic, self.near


@dataclass(frozen=True)
class Placement:
    """Unit space from world space [m]: unit = (world − centre) · scale, in float64."""

    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: float = 1.0


@dataclass(frozen=True)
class LoadReport:
    """What a loader left out (ignored), added or mended (notes), a sentence each; dropped_triangles: of no area.

    beside: files that were looked for beside the scene's, by their names from its folder, and when they were written
    [ns], 0 where they are not there.
    """

    ignored: tuple[str, ...] = ()
    dropped_triangles: int = 0
    notes: tuple[str, ...] = ()
    beside: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Scene:
    """A scene ready for a device: all geometry in unit space (the box [−½, ½]³), every index in range, all finite.

    vertices (vertex, 3), normals (vertex, 3) unit length, uvs (set, vertex, 2), colors (vertex, 4) linear or None,
    triangles (triangle, 3) indices of vertices, triangle_material (triangle,). Light positions and intensities are in
    unit space; cameras are in world space, which `placement` maps to unit space, and `frame` the file's coordinates to.
    bounds: corners, in world space, of the box around all but what is small and far away; choices: what an import
    option can be, by name ("variant", "storey"). objects: their ids; vertex_object (vertex,): whose each vertex is,
    empty where there are none; motion: what time changes, in the file's coordinates.
    """

    name: str
    vertices: Floats
    normals: Floats
    uvs: Floats
    colors: Floats | None
    triangles: Ints
    triangle_material: Ints
    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    lights: tuple[Light, ...]
    sky: Sky | Environment | None
    cameras: tuple[Camera, ...]
    placement: Placement
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]]
    report: LoadReport = field(default_factory=LoadReport)
    frame: FileFrame = field(default_factory=FileFrame)
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)
    objects: tuple[str, ...] = ()
    vertex_object: Ints = field(default_factory=lambda: np.zeros(0, np.int32))
    motion: Motion | None = None

    @cached_property
    def material_areas(self) -> Doubles:
        """Of all triangles of each material, (material,), in unit space."""
        return self._areas_of(slice(None))

    @cached_property
    def light_areas(self) -> Doubles:
        """As `material_areas`, of materials that emit; 0 of others, which are most of a scene."""
        emits = np.array([material.emits for material in self.materials])
        return self._areas_of(np.flatnonzero(emits[self.triangle_material]))

    def _areas_of(self, chosen: Integers | slice) -> Doubles:
        triangles, materials = self.triangles[chosen], self.triangle_material[chosen]
        a, b, c = (self.vertices.take(triangles[:, corner], axis=0).astype(np.float64) for corner in range(3))
        e, f = b - a, c - a
        ee, ff, ef = (np.einsum("tk,tk->t", *pair) for pair in ((e, e), (f, f), (e, f)))
        areas = np.sqrt(np.maximum(ee * ff - ef * ef, 0.0)) / 2.0
        return np.bincount(materials, areas, len(self.materials)).astype(np.float64)

    @cached_property
    def material_triangles(self) -> Ints:
        """How many triangles each material has, (material,)."""
        return np.bincount(self.triangle_material, minlength=len(self.materials)).astype(np.int32)

    def relit(
        self, materials: tuple[Material, ...], lights: tuple[Light, ...], sky: Sky | Environment | None
    ) -> "Scene":
        """The scene with these, as many materials as it has; what it knew of its triangles it knows."""
        scene = replace(self, materials=materials, lights=lights, sky=sky)
        scene.__dict__["material_triangles"] = self.material_triangles
        return scene

    @cached_property
    def least_vertex_alpha(self) -> float:
        """The least alpha of its vertex colours, 1 without any."""
        return 1.0 if self.colors is None else float(self.colors[:, 3].min(initial=1.0))

    @cached_property
    def object_runs(self) -> tuple[Integers, Ints]:
        """Where runs of vertices of one object begin, and whose each is: few, as meshes lie one behind the other."""
        begins = np.flatnonzero(np.diff(self.vertex_object, prepend=-1))
        return begins, self.vertex_object[begins]

    @cached_property
    def object_boxes(self) -> tuple[Doubles, Doubles]:
        """The low and the high corners (object, 3) of the boxes around the objects, in world space."""
        low, high = np.full((len(self.objects), 3), np.inf), np.full((len(self.objects), 3), -np.inf)
        if self.objects:
            begins, numbers = self.object_runs
            np.minimum.at(low, numbers, np.minimum.reduceat(self.vertices, begins, axis=0))
            np.maximum.at(high, numbers, np.maximum.reduceat(self.vertices, begins, axis=0))
        placement = self.placement
        return low / placement.scale + placement.centre, high / placement.scale + placement.centre

    @cached_property
    def body_triangles(self) -> tuple[tuple[Body, slice], ...]:
        """The bodies of its motion that it shows, and the triangles of each, which lie one behind the other."""
        bodies = () if self.motion is None else self.motion.bodies
        number = np.full(len(self.vertices), len(bodies))
        for index, body in enumerate(bodies):
            number[body.first_vertex : body.first_vertex + len(body.vertices)] = index
        owner = number[self.triangles[:, 0]]
        starts = np.flatnonzero(np.diff(owner, prepend=-1)).tolist()
        runs = zip(owner[starts].tolist(), starts, [*starts[1:], len(owner)], strict=True)
        return tuple((bodies[index], slice(begin, end)) for index, begin, end in runs if index < len(bodies))
