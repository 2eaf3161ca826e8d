"""Reading textures: wrap modes, bilinear filtering and sRGB decoding of RGBA8 texels."""

import warp as wp

from gpu.device_scene.data import NO_TEXTURE, SceneData, SlotData, TextureData

WRAP_CLAMP = wp.constant(1)
WRAP_MIRROR = wp.constant(2)


@wp.func
def wrapped(index: int, size: int, mode: int) -> int:
    """A texel's index brought into [0, size) by a wrap mode of gpu.scene.types.Wrap."""
    if mode == WRAP_CLAMP:
        return wp.clamp(index, 0, size - 1)
    period = wp.where(mode == WRAP_MIRROR, 2 * size, size)
    rest = index % period
    if rest < 0:
        rest += period
    return wp.where(rest < size, rest, 2 * size - 1 - rest)


@wp.func
def texel(scene: SceneData, texture: TextureData, x: int, y: int) -> wp.vec4:
    """One texel as linear RGBA."""
    row = wrapped(y, texture.height, texture.wrap_t)
    column = wrapped(x, texture.width, texture.wrap_s)
    packed = scene.texels[texture.first + row * texture.width + column]
    r = int(packed & wp.uint32(255))
    g = int((packed >> wp.uint32(8)) & wp.uint32(255))
    b = int((packed >> wp.uint32(16)) & wp.uint32(255))
    a = float((packed >> wp.uint32(24)) & wp.uint32(255)) / 255.0
    if texture.srgb:
        return wp.vec4(scene.decode[r], scene.decode[g], scene.decode[b], a)
    return wp.vec4(float(r) / 255.0, float(g) / 255.0, float(b) / 255.0, a)


@wp.func
def sample_texture(scene: SceneData, slot: SlotData, uv: wp.vec2) -> wp.vec4:
    """The texture of `slot` at the vertex coordinates `uv`, as linear RGBA."""
    texture = scene.textures[slot.texture]
    place = wp.vec3(uv[0], uv[1], 1.0)
    # Coordinates are folded before they become integers, so that huge ones cannot overflow.
    s = wp.dot(slot.row_u, place)
    t = wp.dot(slot.row_v, place)
    x = (s - 2.0 * wp.floor(0.5 * s)) * float(texture.width)
    y = (t - 2.0 * wp.floor(0.5 * t)) * float(texture.height)
    if texture.wrap_s == WRAP_CLAMP:
        x = wp.clamp(s, 0.0, 1.0) * float(texture.width)
    if texture.wrap_t == WRAP_CLAMP:
        y = wp.clamp(t, 0.0, 1.0) * float(texture.height)
    if texture.nearest:
        return texel(scene, texture, int(wp.floor(x)), int(wp.floor(y)))
    x -= 0.5
    y -= 0.5
    left = int(wp.floor(x))
    top = int(wp.floor(y))
    fx = x - float(left)
    fy = y - float(top)
    upper = texel(scene, texture, left, top) * (1.0 - fx) + texel(scene, texture, left + 1, top) * fx
    lower = texel(scene, texture, left, top + 1) * (1.0 - fx) + texel(scene, texture, left + 1, top + 1) * fx
    return upper * (1.0 - fy) + lower * fy


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
    """The texture of `slot` at a triangle's barycentrics as linear RGBA; white where the slot is empty."""
    if not scene.textured or slot.texture == NO_TEXTURE:
        return wp.vec4(1.0, 1.0, 1.0, 1.0)
    return sample_texture(scene, slot, interpolated_uv(scene, slot.uv_set, face, u, v))


@wp.func
def sample_alpha(scene: SceneData, face: int, u: float, v: float) -> float:
    """A triangle's alpha at its barycentrics: factor × texture × vertex colour."""
    material = scene.materials[scene.triangle_material[face]]
    alpha = material.base_color[3] * sample_slot(scene, material.base_color_slot, face, u, v)[3]
    if scene.has_colors:
        corner = scene.triangles[face]
        alpha *= (
            scene.colors[corner[0]][3] * u + scene.colors[corner[1]][3] * v + scene.colors[corner[2]][3] * (1.0 - u - v)
        )
    return alpha
