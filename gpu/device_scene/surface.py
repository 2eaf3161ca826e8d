"""A scene's surface at a ray's hit: position, normals and what it reflects and emits."""

from dataclasses import dataclass

import warp as wp

from gpu.device_scene.data import EMISSION, Hit, SceneData
from gpu.device_scene.offsets import drawn_back
from gpu.device_scene.sheen import LEAST_ROUGHNESS, sheen_reflectance
from gpu.device_scene.sides import emits_from_back, solid_share, triangle_normal
from gpu.device_scene.textures import NO_MAP, sample_use, texels_at
from gpu.device_scene.thin_film import film_reflectance, schlick_rise
from gpu.scene.types import CLEAR_ROUGHNESS

# Glass of a lower index refracts nothing, which the formulas of rough glass divide by.
MIN_IOR = wp.constant(1.0001)


@dataclass(frozen=True)
class SurfaceParameters:
    """How smooth surfaces are taken to be; all roughness is perceptual, √α.

    mirror: smoother metals are perfect mirrors to paths, as glass of CLEAR_ROUGHNESS is perfectly clear: nothing else
    would ever hit their lobes. least: lobes of less would make highlights of punctual lights too small to be seen.
    """

    mirror: float = 0.03
    least: float = 0.05


SURFACE_PARAMETERS = SurfaceParameters()


@wp.struct
class Surface:
    """A point of a surface, both normals turned to the side it was hit from.

    albedo: base colour, which also tints glass; diffuse: reflectance of the diffuse lobe; f0, f90: specular reflectance
    at normal and at grazing incidence; roughness: perceptual;
    mirror: reflects perfectly, by f0, without a lobe; emission: radiance towards the ray's origin [W/m²/sr].
    glass: share of the surface that is glass, the rest reflects as above; clear: its rays stay sharp; thin: of a sheet;
    eta: refractive index behind the surface over that before it; dispersion: of glass; absorption: in what is behind it
    [1/unit length];
    crossed: its glass only reflects, since rays that go through have not met it. coat: how much of a clear coat is over
    all that, of roughness coat_roughness and with a normal of its own. sheen: colour of fibres, of roughness
    sheen_roughness, over what is no glass; below zero where they take light and send none (gpu.gbuffer.drawn_side);
    what they take of the light that comes from there to where the surface is seen from, diffuse, f0 and f90 are
    without. film: how much of a thin film is over the faces that reflect, of index
    film_ior and film_thickness [nm]; film_f0: specular reflectance below it over f90, at normal incidence. f0 is that
    with which Schlick's law has the film's colour from where the surface is seen. grain: where highlights are long, a
    direction across `normal` that is as long as α along it is nearer to 1; zero without. through: what the diffuse lobe
    scatters of light from behind, which `diffuse` is without.
    """

    position: wp.vec3
    geometric_normal: wp.vec3
    normal: wp.vec3
    albedo: wp.vec3
    diffuse: wp.vec3
    emission: wp.vec3
    f0: wp.vec3
    f90: float
    roughness: float
    mirror: bool
    glass: float
    clear: bool
    thin: bool
    eta: float
    dispersion: float
    absorption: wp.vec3
    crossed: bool
    coat: float
    coat_roughness: float
    coat_normal: wp.vec3
    sheen: wp.vec3
    sheen_roughness: float
    film: float
    film_ior: float
    film_thickness: float
    film_f0: wp.vec3
    grain: wp.vec3
    through: wp.vec3


@wp.func
def tangent_of(scene: SceneData, face: int, normal: wp.vec3, uv_set: int) -> wp.vec4:
    """The unit tangent across `normal` along which u of a UV set grows, zero where there is none; and the sign of the
    set's area, which mirrors v.
    """
    corner = scene.triangles[face]
    p0 = scene.vertices[corner[0]]
    uv0 = scene.uvs[uv_set, corner[0]]
    edge1 = scene.vertices[corner[1]] - p0
    edge2 = scene.vertices[corner[2]] - p0
    d1 = scene.uvs[uv_set, corner[1]] - uv0
    d2 = scene.uvs[uv_set, corner[2]] - uv0
    determinant = d1[0] * d2[1] - d1[1] * d2[0]
    along_u = (edge1 * d2[1] - edge2 * d1[1]) * wp.sign(determinant)
    tangent = along_u - normal * wp.dot(along_u, normal)
    if wp.length_sq(tangent) == 0.0:
        return wp.vec4(0.0, 0.0, 0.0, 0.0)
    tangent = wp.normalize(tangent)
    return wp.vec4(tangent[0], tangent[1], tangent[2], wp.sign(determinant))


@wp.func
def along_surface(tangent: wp.vec4, normal: wp.vec3, x: float, y: float) -> wp.vec3:
    """(x, y) of a texture of directions by `tangent_of` and the `normal` of a triangle's front."""
    along = wp.vec3(tangent[0], tangent[1], tangent[2])
    # glTF: green points up in the image, against v. Where u × v points along the normal, that is against normal × u.
    return along * x + wp.cross(normal, along) * (-tangent[3] * y)


@wp.func
def bent_normal(scene: SceneData, face: int, normal: wp.vec3, place: wp.vec3, uv_set: int, scale: float) -> wp.vec3:
    """The interpolated `normal` bent by what a map has at a `place`, if there is one, that follows a UV set."""
    if uv_set == NO_MAP:
        return normal
    tangent = tangent_of(scene, face, normal, uv_set)
    if tangent[3] == 0.0:
        return normal
    x = (2.0 * place[0] - 1.0) * scale
    y = (2.0 * place[1] - 1.0) * scale
    return wp.normalize(along_surface(tangent, normal, x, y) + normal * wp.max(2.0 * place[2] - 1.0, 0.01))


@wp.func
def grain_at(scene: SceneData, face: int, front: wp.vec3, normal: wp.vec3, texel: wp.vec3) -> wp.vec3:
    """Surface.grain of a triangle whose shading `normal` on its `front` is known, where the map has `texel`
    (KHR_materials_anisotropy).
    """
    material = scene.materials[scene.triangle_material[face]]
    tangent = tangent_of(scene, face, normal, material.grain_set)
    x = 2.0 * texel[0] - 1.0
    y = 2.0 * texel[1] - 1.0
    turn = material.grain_turn
    along = along_surface(tangent, front, x * turn[0] - y * turn[1], x * turn[1] + y * turn[0])
    along = along - normal * wp.dot(along, normal)
    if wp.length_sq(along) == 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    strength = material.grain * texel[2]
    return wp.normalize(along) * (strength * strength)


@wp.func
def shading_normal(surface: Surface, bent: wp.vec3, seen_front: bool, direction: wp.vec3) -> wp.vec3:
    """A `bent` normal of a triangle's front on the side of `surface` that a ray along unit `direction` sees; the
    geometric one where it would face away from that.
    """
    normal = wp.where(seen_front, bent, -bent)
    if wp.dot(normal, surface.geometric_normal) <= 0.0:
        return surface.geometric_normal
    # A shading normal that faces away from the viewer would shade black; tilt it back to the horizon.
    facing = wp.dot(normal, direction)
    if facing > 0.0:
        normal = wp.normalize(normal - direction * (1.001 * facing))
    return normal


@wp.func
def albedo_of(scene: SceneData, face: int, u: float, v: float, texel: wp.vec3) -> wp.vec3:
    """Base colour: factor × texture × vertex colour, linear RGB in [0, 1]; texel: of the texture there."""
    factor = scene.materials[scene.triangle_material[face]].base_color
    colour = wp.vec3(factor[0] * texel[0], factor[1] * texel[1], factor[2] * texel[2])
    if scene.has_colors:
        corner = scene.triangles[face]
        tint = scene.colors[corner[0]] * u + scene.colors[corner[1]] * v + scene.colors[corner[2]] * (1.0 - u - v)
        colour = wp.cw_mul(colour, wp.vec3(tint[0], tint[1], tint[2]))
    return wp.min(colour, wp.vec3(1.0, 1.0, 1.0))


@wp.func
def emission_at(scene: SceneData, face: int, u: float, v: float) -> wp.vec3:
    """Radiance of a triangle's sides that emit [W/m²/sr], to rays that meet it: factor × strength × texture; none where
    alpha cuts away.
    """
    emission = scene.materials[scene.triangle_material[face]].emission
    if emission == wp.vec3(0.0, 0.0, 0.0):
        return emission
    if solid_share(scene, face, u, v) == 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    texture = sample_use(scene, EMISSION, face, u, v)
    return wp.cw_mul(emission, wp.vec3(texture[0], texture[1], texture[2]))


@wp.func
def emitted_at(scene: SceneData, face: int, u: float, v: float) -> wp.vec3:
    """`emission_at` as a place that is chosen, not met, emits it: of BLEND the share that is there."""
    return emission_at(scene, face, u, v) * solid_share(scene, face, u, v)


@wp.func
def film_fresnel(surface: Surface, cosine: float) -> wp.vec3:
    """Reflectance of microfacets with a film over them that are seen at an angle of `cosine`."""
    rise = schlick_rise(cosine)
    plain = surface.film_f0 * (1.0 - rise) + wp.vec3(rise, rise, rise)
    film = film_reflectance(cosine, surface.film_ior, surface.film_thickness, surface.film_f0)
    return wp.lerp(plain, film, surface.film) * surface.f90


@wp.func
def below_film(surface: Surface, view: wp.vec3, film: float, ior: float, thickness: float) -> Surface:
    """`surface` with so much of a film over it, of this index and thickness [nm], as it is seen from unit `view`."""
    if surface.f90 == 0.0:
        return surface
    surface.film = film
    surface.film_ior = ior
    surface.film_thickness = thickness
    surface.film_f0 = surface.f0 / surface.f90
    cosine = wp.dot(surface.normal, view)
    rise = wp.min(schlick_rise(cosine), 0.99)
    f90 = wp.vec3(surface.f90, surface.f90, surface.f90)
    f0 = (film_fresnel(surface, cosine) - f90 * rise) / (1.0 - rise)
    surface.f0 = wp.min(wp.max(f0, wp.vec3(0.0, 0.0, 0.0)), f90)
    return surface


@wp.func
def left_by_sheen(surface: Surface, cosine: float) -> float:
    """What fibres leave of light at an angle of `cosine` to what is below them (the extension's albedo scaling)."""
    color = surface.sheen
    most = wp.max(color[0], wp.max(color[1], color[2]))
    return 1.0 - most * sheen_reflectance(cosine, wp.abs(surface.sheen_roughness))


@wp.func
def below_sheen(surface: Surface, view: wp.vec3, color: wp.vec3, roughness: float) -> Surface:
    """`surface` with fibres of this colour and roughness over it, as it is seen from unit `view`."""
    surface.sheen = color
    surface.sheen_roughness = wp.max(roughness, LEAST_ROUGHNESS)
    left = left_by_sheen(surface, wp.dot(surface.normal, view))
    surface.diffuse = surface.diffuse * left
    surface.through = surface.through * left
    surface.f0 = surface.f0 * left
    surface.f90 = surface.f90 * left
    surface.mirror = False
    return surface


@wp.func
def hit_at(scene: SceneData, face: int, position: wp.vec3) -> Hit:
    """The hit of a triangle at a `position` on it, without the distance of a ray."""
    corner = scene.triangles[face]
    last = scene.vertices[corner[2]]
    a = scene.vertices[corner[0]] - last
    b = scene.vertices[corner[1]] - last
    normal = wp.cross(a, b)
    square = wp.dot(normal, normal)
    hit = Hit()
    hit.face = face
    hit.u = wp.dot(wp.cross(position - last, b), normal) / square
    hit.v = wp.dot(wp.cross(a, position - last), normal) / square
    return hit


@wp.func
def surface_at(scene: SceneData, hit: Hit, direction: wp.vec3) -> Surface:
    """The surface that a ray along unit `direction` hit; `hit` must be one."""
    surface = Surface()
    corner = scene.triangles[hit.face]
    w = 1.0 - hit.u - hit.v
    material = scene.materials[scene.triangle_material[hit.face]]
    front = triangle_normal(scene, hit.face)
    seen_front = wp.dot(front, direction) < 0.0
    surface.geometric_normal = wp.where(seen_front, front, -front)
    surface.position = drawn_back(
        scene.vertices[corner[0]] * hit.u + scene.vertices[corner[1]] * hit.v + scene.vertices[corner[2]] * w,
        surface.geometric_normal,
        direction,
    )
    texels = texels_at(scene, hit.face, hit.u, hit.v)
    base = albedo_of(scene, hit.face, hit.u, hit.v, texels.base_color)
    if seen_front or emits_from_back(scene, hit.face):
        surface.emission = emission_at(scene, hit.face, hit.u, hit.v)
    surface.normal = surface.geometric_normal
    surface.albedo = base
    surface.diffuse = base
    surface.roughness = 1.0
    if scene.lambertian:
        return surface
    if material.unlit:
        surface.emission = base
        surface.albedo = wp.vec3(0.0, 0.0, 0.0)
        surface.diffuse = wp.vec3(0.0, 0.0, 0.0)
        return surface
    smooth = scene.normals[corner[0]] * hit.u + scene.normals[corner[1]] * hit.v + scene.normals[corner[2]] * w
    if wp.length_sq(smooth) > 0.0:
        smooth = wp.normalize(smooth)
        bent = bent_normal(scene, hit.face, smooth, texels.normal, texels.normal_set, material.normal_scale)
        surface.normal = shading_normal(surface, bent, seen_front, direction)
    metallic = material.metallic * texels.metallic
    roughness = material.roughness * texels.roughness
    surface.roughness = wp.max(roughness, wp.static(SURFACE_PARAMETERS.least))
    surface.mirror = metallic == 1.0 and roughness < wp.static(SURFACE_PARAMETERS.mirror)
    reflectance = (material.ior - 1.0) / (material.ior + 1.0)
    specular = material.specular * texels.specular
    color = wp.cw_mul(material.specular_color, texels.specular_color)
    dielectric = wp.min(color * (reflectance * reflectance), wp.vec3(1.0, 1.0, 1.0)) * specular
    surface.f0 = dielectric * (1.0 - metallic) + base * metallic
    surface.f90 = specular * (1.0 - metallic) + metallic
    surface.diffuse = base * (1.0 - metallic)
    if scene.coated and material.coat > 0.0:
        surface.coat = material.coat * texels.coat
        roughness_of_coat = material.coat_roughness * texels.coat_roughness
        surface.coat_roughness = wp.max(roughness_of_coat, wp.static(SURFACE_PARAMETERS.least))
        surface.coat_normal = surface.geometric_normal
        if wp.length_sq(smooth) > 0.0:
            scale = material.coat_normal_scale
            bent = bent_normal(scene, hit.face, smooth, texels.coat_normal, texels.coat_normal_set, scale)
            surface.coat_normal = shading_normal(surface, bent, seen_front, direction)
    if scene.transmissive and material.transmission > 0.0:
        surface.glass = material.transmission * texels.transmission * (1.0 - metallic)
        surface.clear = roughness <= wp.static(CLEAR_ROUGHNESS)
        surface.thin = material.thin
        index = wp.max(material.ior, MIN_IOR)
        surface.eta = wp.where(seen_front or material.thin, index, 1.0 / index)
        if scene.dispersive:
            surface.dispersion = material.dispersion
        if seen_front and not material.thin:
            surface.absorption = material.absorption
    if scene.translucent and material.through > 0.0:
        share = material.through * texels.through
        surface.through = wp.cw_mul(material.through_color, texels.through_color) * (share * (1.0 - metallic))
        surface.diffuse = surface.diffuse * (1.0 - share)
        surface.thin = material.thin
        if seen_front and not material.thin:
            surface.absorption = material.absorption
    if scene.filmed and material.film > 0.0:
        thickness = wp.lerp(material.film_least, material.film_most, texels.film_thickness)
        surface = below_film(surface, -direction, material.film * texels.film, material.film_ior, thickness)
    if scene.sheened and wp.length_sq(material.sheen_color) > 0.0 and surface.glass == 0.0:
        color = wp.cw_mul(material.sheen_color, texels.sheen_color)
        surface = below_sheen(surface, -direction, color, material.sheen_roughness * texels.sheen_roughness)
    if scene.grained and material.grain > 0.0 and surface.glass == 0.0:
        surface.grain = grain_at(scene, hit.face, front, surface.normal, texels.grain)
        surface.mirror = False
    return surface
