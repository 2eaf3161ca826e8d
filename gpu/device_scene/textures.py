"""Reading textures: wrap modes, bilinear filtering and sRGB decoding of RGBA8 texels."""

import warp as wp

from gpu.device_scene.data import (
    BASE_COLOR,
    COAT,
    COAT_NORMAL,
    COAT_ROUGHNESS,
    EMISSION,
    FILM,
    FILM_THICKNESS,
    GRAIN,
    METALLIC_ROUGHNESS,
    NORMAL,
    SHEEN_COLOR,
    SHEEN_ROUGHNESS,
    SPECULAR,
    SPECULAR_COLOR,
    THROUGH,
    THROUGH_COLOR,
    TRANSMISSION,
    SceneData,
    SlotData,
    TextureData,
)

WRAP_CLAMP = wp.constant(1)
WRAP_MIRROR = wp.constant(2)
NO_MAP = wp.constant(-1)


@wp.func
def wrapped(index: int, size: int, mode: int) -> int:
    """A texel's index, from -1 to 2·size, brought into [0, size) by a wrap mode of gpu.scene.types.Wrap; any other,
    as of coordinates that are no numbers, comes to lie there, too.
    """
    rest = index
    if mode != WRAP_CLAMP:
        period = wp.where(mode == WRAP_MIRROR, 2 * size, size)
        rest = wp.where(index < 0, index + period, index)
        rest = wp.where(rest < period, rest, rest - period)
        rest = wp.where(rest < period, rest, rest - period)
        rest = wp.where(rest < size, rest, 2 * size - 1 - rest)
    return wp.clamp(rest, 0, size - 1)


@wp.func
def texel(texels: wp.array[wp.uint32], decode: wp.array[float], texture: TextureData, place: int) -> wp.vec4:
    """One texel of a texture as linear RGBA; place: row by row."""
    packed = texels[texture.first + place]
    r = int(packed & wp.uint32(255))
    g = int((packed >> wp.uint32(8)) & wp.uint32(255))
    b = int((packed >> wp.uint32(16)) & wp.uint32(255))
    a = int((packed >> wp.uint32(24)) & wp.uint32(255))
    coding = wp.where(texture.srgb, 256, 0)
    return wp.vec4(decode[coding + r], decode[coding + g], decode[coding + b], decode[a])


# Called, not inlined, as kernels have it up to 28 times, which takes compilers a third of their time; so arrays come as
# addresses, in registers.
@wp.func(inline=False)
def filtered(textures: wp.uint64, all_texels: wp.uint64, decoded: wp.uint64, index: int, s: float, t: float) -> wp.vec4:
    """A texture at its coordinates, as linear RGBA. textures, all_texels, decoded: addresses of SceneData's arrays."""
    texture = wp.array(ptr=textures, shape=(index + 1,), dtype=TextureData)[index]
    texels = wp.array(ptr=all_texels, shape=(texture.first + texture.width * texture.height,), dtype=wp.uint32)
    decode = wp.array(ptr=decoded, shape=(512,), dtype=float)
    # Coordinates are folded before they become integers, so that huge ones cannot overflow.
    x = (s - 2.0 * wp.floor(0.5 * s)) * float(texture.width)
    y = (t - 2.0 * wp.floor(0.5 * t)) * float(texture.height)
    if texture.wrap_s == WRAP_CLAMP:
        x = wp.clamp(s, 0.0, 1.0) * float(texture.width)
    if texture.wrap_t == WRAP_CLAMP:
        y = wp.clamp(t, 0.0, 1.0) * float(texture.height)
    # Of one that is not filtered, only the first of the four counts.
    to_middle = wp.where(texture.nearest, 0.0, 0.5)
    left = int(wp.floor(x - to_middle))
    top = int(wp.floor(y - to_middle))
    fx = wp.where(texture.nearest, 0.0, x - to_middle - float(left))
    fy = wp.where(texture.nearest, 0.0, y - to_middle - float(top))
    first = wrapped(left, texture.width, texture.wrap_s)
    second = wrapped(left + 1, texture.width, texture.wrap_s)
    above = wrapped(top, texture.height, texture.wrap_t) * texture.width
    below = wrapped(top + 1, texture.height, texture.wrap_t) * texture.width
    upper = texel(texels, decode, texture, above + first) * (1.0 - fx)
    upper += texel(texels, decode, texture, above + second) * fx
    lower = texel(texels, decode, texture, below + first) * (1.0 - fx)
    lower += texel(texels, decode, texture, below + second) * fx
    return upper * (1.0 - fy) + lower * fy


@wp.func
def sample_texture(scene: SceneData, slot: SlotData, uv: wp.vec2) -> wp.vec4:
    """The texture of `slot` at the vertex coordinates `uv`, as linear RGBA."""
    place = wp.vec3(uv[0], uv[1], 1.0)
    s = wp.dot(slot.row_u, place)
    t = wp.dot(slot.row_v, place)
    return filtered(scene.textures.ptr, scene.texels.ptr, scene.decode.ptr, slot.texture, s, t)


@wp.func
def interpolated_uv(scene: SceneData, uv_set: int, face: int, u: float, v: float) -> wp.vec2:
    """UV coordinates of set `uv_set` at a triangle's barycentrics."""
    corner = scene.triangles[face]
    return (
        scene.uvs[uv_set, corner[0]] * u
        + scene.uvs[uv_set, corner[1]] * v
        + scene.uvs[uv_set, corner[2]] * (1.0 - u - v)
    )


@wp.func
def sample_slot(scene: SceneData, slot: SlotData, face: int, u: float, v: float) -> wp.vec4:
    """The texture of `slot` at a triangle's barycentrics, as linear RGBA."""
    return sample_texture(scene, slot, interpolated_uv(scene, slot.uv_set, face, u, v))


@wp.func
def sample_use(scene: SceneData, use: int, face: int, u: float, v: float) -> wp.vec4:
    """The texture that a triangle's material has for `use`, as linear RGBA; white where it has none."""
    if scene.textured:
        material = scene.materials[scene.triangle_material[face]]
        for index in range(material.first_slot, material.first_slot + material.slots):
            if scene.slots[index].use == use:
                return sample_slot(scene, scene.slots[index], face, u, v)
    return wp.vec4(1.0, 1.0, 1.0, 1.0)


@wp.func
def sample_alpha(scene: SceneData, face: int, u: float, v: float) -> float:
    """A triangle's alpha at its barycentrics: factor × texture × vertex colour."""
    alpha = scene.materials[scene.triangle_material[face]].base_color[3]
    if not scene.cutouts:
        return alpha
    alpha *= sample_use(scene, BASE_COLOR, face, u, v)[3]
    if scene.has_colors:
        corner = scene.triangles[face]
        alpha *= (
            scene.colors[corner[0]][3] * u + scene.colors[corner[1]][3] * v + scene.colors[corner[2]][3] * (1.0 - u - v)
        )
    return alpha


@wp.struct
class MaterialTexels:
    """What a material's textures say of a place, but for emission: 1 where there is none. normal, coat_normal, grain:
    as the maps have them, from 0 to 1; normal_set, coat_normal_set: the UV sets that they follow, NO_MAP without one.
    """

    base_color: wp.vec3
    roughness: float
    metallic: float
    transmission: float
    specular: float
    specular_color: wp.vec3
    sheen_color: wp.vec3
    sheen_roughness: float
    film: float
    film_thickness: float
    grain: wp.vec3
    through: float
    through_color: wp.vec3
    coat: float
    coat_roughness: float
    normal: wp.vec3
    normal_set: int
    coat_normal: wp.vec3
    coat_normal_set: int


@wp.func
def texels_at(scene: SceneData, face: int, u: float, v: float) -> MaterialTexels:
    """Those of a triangle's material at its barycentrics; of base colour alone where all is Lambertian.

    One loop over what there is, since kernels would have the code of a texture a dozen times else.
    """
    texels = MaterialTexels()
    texels.base_color = wp.vec3(1.0, 1.0, 1.0)
    texels.roughness = 1.0
    texels.metallic = 1.0
    texels.transmission = 1.0
    texels.specular = 1.0
    texels.specular_color = wp.vec3(1.0, 1.0, 1.0)
    texels.sheen_color = wp.vec3(1.0, 1.0, 1.0)
    texels.sheen_roughness = 1.0
    texels.film = 1.0
    texels.film_thickness = 1.0
    texels.grain = wp.vec3(1.0, 0.5, 1.0)
    texels.through = 1.0
    texels.through_color = wp.vec3(1.0, 1.0, 1.0)
    texels.coat = 1.0
    texels.coat_roughness = 1.0
    texels.normal_set = NO_MAP
    texels.coat_normal_set = NO_MAP
    if scene.textured:
        material = scene.materials[scene.triangle_material[face]]
        for index in range(material.first_slot, material.first_slot + material.slots):
            slot = scene.slots[index]
            wanted = slot.use == BASE_COLOR or (not scene.lambertian and slot.use != EMISSION)
            if wanted and (scene.coated or slot.use < COAT):
                found = sample_slot(scene, slot, face, u, v)
                colour = wp.vec3(found[0], found[1], found[2])
                if slot.use == BASE_COLOR:
                    texels.base_color = colour
                elif slot.use == METALLIC_ROUGHNESS:
                    texels.roughness = found[1]
                    texels.metallic = found[2]
                elif slot.use == NORMAL:
                    texels.normal = colour
                    texels.normal_set = slot.uv_set
                elif slot.use == TRANSMISSION:
                    texels.transmission = found[0]
                elif slot.use == SPECULAR:
                    texels.specular = found[3]
                elif slot.use == SPECULAR_COLOR:
                    texels.specular_color = colour
                elif scene.sheened and slot.use == SHEEN_COLOR:
                    texels.sheen_color = colour
                elif scene.sheened and slot.use == SHEEN_ROUGHNESS:
                    texels.sheen_roughness = found[3]
                elif scene.filmed and slot.use == FILM:
                    texels.film = found[0]
                elif scene.filmed and slot.use == FILM_THICKNESS:
                    texels.film_thickness = found[1]
                elif scene.grained and slot.use == GRAIN:
                    texels.grain = colour
                elif scene.translucent and slot.use == THROUGH:
                    texels.through = found[3]
                elif scene.translucent and slot.use == THROUGH_COLOR:
                    texels.through_color = colour
                elif slot.use == COAT:
                    texels.coat = found[0]
                elif slot.use == COAT_ROUGHNESS:
                    texels.coat_roughness = found[1]
                elif slot.use == COAT_NORMAL:
                    texels.coat_normal = colour
                    texels.coat_normal_set = slot.uv_set
    return texels
