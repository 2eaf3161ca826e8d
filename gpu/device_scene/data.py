"""The scene as kernels see it: structs of arrays and scalars, in unit space."""

import warp as wp

from gpu.core.code_generation import pass_by_reference
from gpu.device_scene.bvh import Bvh

NO_HIT = wp.constant(-1)
# How rays without a seed meet BLEND surfaces: SceneData.coverage.
HALF = wp.constant(wp.uint32(0))
WHOLE = wp.constant(wp.uint32(0xFFFFFFFF))
# What a texture is for: SlotData.use.
BASE_COLOR = wp.constant(0)
EMISSION = wp.constant(1)
METALLIC_ROUGHNESS = wp.constant(2)
NORMAL = wp.constant(3)
TRANSMISSION = wp.constant(4)
SPECULAR = wp.constant(5)
SPECULAR_COLOR = wp.constant(6)
SHEEN_COLOR = wp.constant(7)
SHEEN_ROUGHNESS = wp.constant(8)
FILM = wp.constant(9)
FILM_THICKNESS = wp.constant(10)
GRAIN = wp.constant(11)
THROUGH = wp.constant(12)
THROUGH_COLOR = wp.constant(13)
COAT = wp.constant(14)
COAT_ROUGHNESS = wp.constant(15)
COAT_NORMAL = wp.constant(16)


@wp.struct
class Hit:
    """A ray's hit: triangle `face` (NO_HIT: none) at distance `t`, at the point u·p0 + v·p1 + (1 − u − v)·p2."""

    face: int
    t: float
    u: float
    v: float


@wp.struct
class SlotData:
    """One use of a texture by a material: what for, its index, the UV set, and the two rows that map (u, v, 1)."""

    use: int
    texture: int
    uv_set: int
    row_u: wp.vec3
    row_v: wp.vec3


@wp.struct
class TextureData:
    """An image's place among the texels, and its sampler. Wrap modes as gpu.scene.types.Wrap."""

    first: int
    width: int
    height: int
    srgb: bool
    nearest: bool
    wrap_s: int
    wrap_t: int


@wp.struct
class MaterialData:
    """A material. base_color: linear RGBA; emission: radiance [W/m²/sr]; double_sided: the back emits, too.

    transmission: share that is glass; dispersion: KHR_materials_dispersion; thin: of a sheet, else of a body that
    absorbs `absorption` [1/unit length];
    part_glass: as gpu.scene.types.Material.is_part_glass tells; blend: alpha is the share of the surface that is there;
    slots: it has so many, from `first_slot` on; coat, coat_roughness, coat_normal_scale: KHR_materials_clearcoat;
    sheen_color, sheen_roughness: KHR_materials_sheen; film, film_ior, film_least, film_most: KHR_materials_iridescence,
    the last two of its thickness [nm]; grain: KHR_materials_anisotropy, along grain_turn from where u of the set
    grain_set grows; through, through_color: KHR_materials_diffuse_transmission.
    """

    base_color: wp.vec4
    emission: wp.vec3
    metallic: float
    roughness: float
    ior: float
    dispersion: float
    specular: float
    specular_color: wp.vec3
    coat: float
    coat_roughness: float
    coat_normal_scale: float
    sheen_color: wp.vec3
    sheen_roughness: float
    film: float
    film_ior: float
    film_least: float
    film_most: float
    grain: float
    grain_turn: wp.vec2
    grain_set: int
    through: float
    through_color: wp.vec3
    transmission: float
    thin: bool
    absorption: wp.vec3
    normal_scale: float
    alpha_cutoff: float
    blend: bool
    part_glass: bool
    double_sided: bool
    unlit: bool
    first_slot: int
    slots: int


@wp.struct
class EnvironmentData:
    """Light from all around by a picture, see gpu.scene.types.Environment and gpu.device_scene.environment.

    radiance (height, width) [W/m²/sr], before it is tinted; mean (1,): of all directions and channels of that; rows
    (height,), columns (height, width): where rows, and pixels of a row, end in a choice by brightness, of 2³²; turn:
    share of a full turn.
    """

    width: int
    height: int
    turn: float
    mean: wp.array[float]
    radiance: wp.array2d[wp.vec3]
    rows: wp.array[wp.uint32]
    columns: wp.array2d[wp.uint32]


@pass_by_reference
@wp.struct
class SceneData:
    """The scene as kernels see it, in unit space. The first `opaque_count` triangles are opaque, `pane_count` after
    them panes, which are bodies of clear glass, `masked_count` there in part, by alpha or as glass, and the last
    `backdrop_count` a sky around the scene, which only cameras and its light know.

    vertices, normals (vertex,); uvs (set, vertex); colors (vertex,) linear RGBA, one element when there are none;
    triangles (triangle,) vertex indices; slots (slot,) of the materials, one behind the other; texels (texel,) RGBA8,
    least significant byte red; decode (512,): what bytes stand for where they are linear, then of sRGB; sky (1,):
    radiance of gpu.scene.types.Sky, or the tint of the `environment` that there is instead where has_environment says
    so. alpha: rays must test masks, cutouts: textures or vertices tell what there is of some; textured, glossy, coated,
    sheened, filmed, grained, translucent, transmissive, specular: rays may hit textures, narrow specular lobes, clear
    coats, sheen, thin films, grain, what scatters light to its other side, glass, mirrors or clear glass; blended: or
    surfaces of which rays find a share; sheer: some of them by less than half; one_sided: cameras do not see the
    backs of some surfaces; lambertian: every surface is Lambertian with its geometric normal; ignore_alpha: masks let
    no light through; part_glass: rays may hit sheets of clear glass (gpu.device_scene.part_glass); dispersive: or
    bodies of glass that refract colours otherwise (gpu.device_scene.dispersion); coverage: a seed by
    which rays meet what is there in part by its share; HALF: what is there by one half or more; WHOLE: wherever it
    shows at all.
    """

    opaque: Bvh
    panes: Bvh
    masked: Bvh
    backdrop: Bvh
    opaque_count: int
    pane_count: int
    masked_count: int
    backdrop_count: int
    vertices: wp.array[wp.vec3]
    normals: wp.array[wp.vec3]
    uvs: wp.array2d[wp.vec2]
    colors: wp.array[wp.vec4]
    has_colors: bool
    triangles: wp.array[wp.vec3i]
    triangle_material: wp.array[int]
    materials: wp.array[MaterialData]
    slots: wp.array[SlotData]
    textures: wp.array[TextureData]
    texels: wp.array[wp.uint32]
    decode: wp.array[float]
    sky: wp.array[wp.vec3]
    environment: EnvironmentData
    has_environment: bool
    alpha: bool
    cutouts: bool
    textured: bool
    glossy: bool
    coated: bool
    transmissive: bool
    specular: bool
    one_sided: bool
    lambertian: bool
    ignore_alpha: bool
    blended: bool
    sheer: bool
    sheened: bool
    filmed: bool
    grained: bool
    translucent: bool
    dispersive: bool
    part_glass: bool
    coverage: wp.uint32
