"""Shading points (SPs): primary rays, and what is needed to shade where they end. Step 3 of the 2022 paper."""

from dataclasses import replace
from enum import Enum
from functools import cache

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.bsdf import is_followed, left_by_veil, traced_share
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import LEAST_REFLECTED, even_matt, even_reflectance, even_through
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.scattering import coat_share
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.gbuffer.drawn_side import drawn_side
from gpu.gbuffer.specular_chain import ChainSamples, seen_end


@wp.struct
class GBuffer:
    """What the camera sees, one element a pixel, row by row from the top left.

    face: triangle of the SP, NO_HIT where there is none; position, geometric_normal, normal: of the SP in unit space,
    normals on the side it is seen from; to_camera: unit direction to where the SP is seen from; spacing: size of a
    pixel there; albedo: its gpu.device_scene.even_light.even_reflectance, where `traces_gloss` without what rays of its
    specular lobe look for, of frosted glass without the glass (gpu.indirect.frosted_glass); diffuse, f0, f90,
    roughness: as gpu.device_scene.surface.Surface; throughput: share of the SP's light that reaches the camera,
    where `traces_gloss` without what a clear coat reflects; sheen: its colour and roughness, grain, through: as of
    Surface, one element in scenes without; where chains are drawn, an SP is on one side of what is translucent,
    `to_camera` is mirrored to there, and `through` is zero (gpu.gbuffer.drawn_side); emitted: radiance that reaches the
    camera from emitters and the sky without the SP [W/m²/sr]. chains: whether SPs are seen in mirrors and through
    glass, too (gpu.gbuffer.specular_chain); apparent: then the places where they seem to be, as far along the pixel's
    ray as light has come. gloss, grained, translucent: whether there may be narrow specular lobes, a grain, and
    `through`.
    """

    chains: bool
    gloss: bool
    traces_gloss: bool
    grained: bool
    translucent: bool
    face: wp.array[int]
    position: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    to_camera: wp.array[wp.vec3]
    spacing: wp.array[float]
    albedo: wp.array[wp.vec3]
    diffuse: wp.array[wp.vec3]
    f0: wp.array[wp.vec3]
    f90: wp.array[float]
    roughness: wp.array[float]
    sheen: wp.array[wp.vec4]
    grain: wp.array[wp.vec3]
    through: wp.array[wp.vec3]
    throughput: wp.array[wp.vec3]
    emitted: wp.array[wp.vec3]
    apparent: wp.array[wp.vec3]


def allocate_gbuffer(pixels: int, device: wp.Device, features: SceneFeatures, *, traces_gloss: bool = False) -> GBuffer:
    """One of so many pixels, for a scene of these `features`; traces_gloss: for gpu.indirect.glossy_reflection, too."""
    gbuffer: GBuffer = allocate(GBuffer, pixels, device, pauses=True)
    gbuffer.gloss = features.gloss
    gbuffer.chains, gbuffer.traces_gloss = features.see_through or traces_gloss, traces_gloss
    if not gbuffer.chains:
        gbuffer.apparent = gbuffer.position
    if not features.sheen:
        gbuffer.sheen = wp.zeros(1, dtype=wp.vec4, device=device)
    gbuffer.grained = features.grain
    if not features.grain:
        gbuffer.grain = wp.zeros(1, dtype=wp.vec3, device=device)
    gbuffer.translucent = features.translucent
    if not features.translucent:
        gbuffer.through = wp.zeros(1, dtype=wp.vec3, device=device)
    return gbuffer


@wp.func
def apparent_position(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Where the SP of a pixel seems to be: what moves in the picture as the camera does. For plane mirrors it is where
    any camera sees it.
    """
    if gbuffer.chains:
        return gbuffer.apparent[pixel]
    return gbuffer.position[pixel]


@wp.func
def surface_of(gbuffer: GBuffer, pixel: int) -> Surface:
    """The SP of a pixel as a surface that reflects and is nothing else, without its sheen."""
    surface = Surface()
    surface.position = gbuffer.position[pixel]
    surface.geometric_normal = gbuffer.geometric_normal[pixel]
    surface.normal = gbuffer.normal[pixel]
    surface.diffuse = gbuffer.diffuse[pixel]
    surface.f0 = gbuffer.f0[pixel]
    surface.f90 = gbuffer.f90[pixel]
    surface.roughness = gbuffer.roughness[pixel]
    if gbuffer.grained:
        surface.grain = gbuffer.grain[pixel]
    if gbuffer.translucent:
        surface.through = gbuffer.through[pixel]
    return surface


@cache
def surface_reader(*, sheen: bool, grain: bool, translucent: bool) -> wp.Function:
    """`surface_of` for scenes that have these or not."""

    @wp.func
    def surface_of_pixel(gbuffer: GBuffer, pixel: int) -> Surface:
        gbuffer.grained = wp.static(grain)
        gbuffer.translucent = wp.static(translucent)
        surface = surface_of(gbuffer, pixel)
        if wp.static(sheen):
            fibres = gbuffer.sheen[pixel]
            surface.sheen = wp.vec3(fibres[0], fibres[1], fibres[2])
            surface.sheen_roughness = fibres[3]
        return surface

    return surface_of_pixel


@wp.func
def behind_share(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """The share of what an SP reflects by its albedo that is of light from behind."""
    if not gbuffer.translucent:
        return wp.vec3(0.0, 0.0, 0.0)
    surface = surface_of(gbuffer, pixel)
    if pixel < gbuffer.sheen.shape[0]:
        fibres = gbuffer.sheen[pixel]
        surface.sheen = wp.vec3(fibres[0], fibres[1], fibres[2])
        surface.sheen_roughness = fibres[3]
    through = even_through(surface, gbuffer.to_camera[pixel])
    return wp.cw_div(through, wp.max(gbuffer.albedo[pixel], LEAST_REFLECTED))


@wp.func
def reflectance(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Radiance that the camera gets of an SP per irradiance."""
    return wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI


class Lobes(Enum):
    """What becomes of narrow specular lobes, coats and frosted glass: they count as even, have rays of their own
    besides, or chains go on in them.
    """

    EVEN = "even"
    TRACED = "traced"
    FOLLOWED = "followed"


@made_for(
    *LOOK,
    "one_sided",
    "backdrop",
    "specular",
    "blend",
    "sheer",
    "glass",
    "panes",
    "environment",
    "frosted",
    "coats",
    "dispersion",
)
def primary_ray_kernel(features: SceneFeatures, lobes: Lobes) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, frosted, coats, fibrous, films, grained = (
        specialisation(features), features.frosted, features.coats, features.sheen, features.films, features.grain
    )  # fmt: skip
    translucent, part_glass = features.translucent, features.part_glass

    @wp.kernel(module="unique")
    def primary_ray_kernel(
        first: int,
        scene: SceneData,
        cameras: wp.array[CameraData],
        image: ImageSize,
        samples: ChainSamples,
        out: GBuffer,
    ) -> None:
        """One thread a pixel: its ray and the surface that it ends at. cameras: one element."""
        pixel = first + wp.tid()
        scene = specialise(scene)
        camera = cameras[0]
        ray = pixel_ray(camera, pixel, image)
        if wp.static(lobes is Lobes.FOLLOWED):
            scene.specular = True
        samples.lobes = wp.static(lobes is Lobes.FOLLOWED)
        end = seen_end(scene, ray, pixel, image, samples, False)
        if wp.static(translucent) and samples.frame_index[0] >= 0:
            end = drawn_side(end, samples, pixel, image)
        out.face[pixel] = end.face
        out.to_camera[pixel] = end.to_viewer
        out.throughput[pixel] = end.throughput
        if wp.static(coats and lobes is Lobes.TRACED):
            # What the coat reflects is seen besides (gpu.indirect.clear_coat).
            out.throughput[pixel] = end.throughput * (1.0 - coat_share(end.surface, end.to_viewer))
        out.emitted[pixel] = end.emitted
        if end.face == NO_HIT:
            return
        surface = end.surface
        out.position[pixel] = surface.position
        if out.chains:
            out.apparent[pixel] = ray.origin + ray.direction * end.length
        out.geometric_normal[pixel] = surface.geometric_normal
        out.normal[pixel] = surface.normal
        distance = wp.where(camera.orthographic, 1.0, ray.start + end.length)
        out.spacing[pixel] = distance * 2.0 * camera.half_height / float(image.height)
        even = even_reflectance(surface, end.to_viewer)
        if wp.static(lobes is Lobes.FOLLOWED):
            if is_followed(surface):
                even = even_matt(surface, end.to_viewer)
        elif wp.static(lobes is Lobes.TRACED):
            even -= (even - even_matt(surface, end.to_viewer)) * traced_share(surface.roughness, surface.f90)
        if wp.static(frosted and lobes is Lobes.TRACED):
            # Of what is no glass the lobes count as even.
            glass = surface.glass
            surface.glass = 0.0
            matt = even_reflectance(surface, end.to_viewer) * (1.0 - glass)
            even = wp.where(glass > 0.0, matt, even)
            if wp.static(translucent):
                surface.through = surface.through * (1.0 - glass)
                matt -= surface.through
            surface.diffuse = wp.where(glass > 0.0, matt, surface.diffuse)
            surface.f90 = wp.where(glass > 0.0, 0.0, surface.f90)
        if wp.static(part_glass and lobes is Lobes.EVEN):
            left = 1.0 - wp.where(surface.crossed, surface.glass, 0.0)  # without mirrors, which are but of even light
            surface.diffuse = surface.diffuse * left
            surface.f0 = surface.f0 * left
            surface.f90 = surface.f90 * left
        if wp.static(films):
            clear = left_by_veil(surface, end.to_viewer)
            surface.diffuse = wp.cw_mul(surface.diffuse, clear)
            surface.through = wp.cw_mul(surface.through, clear)
        out.albedo[pixel] = even
        out.diffuse[pixel] = surface.diffuse
        out.f0[pixel] = surface.f0
        out.f90[pixel] = surface.f90
        out.roughness[pixel] = surface.roughness
        if wp.static(fibrous):
            sheen = surface.sheen
            out.sheen[pixel] = wp.vec4(sheen[0], sheen[1], sheen[2], surface.sheen_roughness)
        if wp.static(grained):
            out.grain[pixel] = surface.grain
        if wp.static(translucent):
            out.through[pixel] = surface.through

    return primary_ray_kernel


def trace_primary_rays(scene: SceneData, camera: wp.array, size: tuple[int, int], out: GBuffer, samples: ChainSamples,
                       features: SceneFeatures = EVERYTHING) -> None:  # fmt: skip
    """Fill `out` for an image of `size` (width, height) through `camera`, (1,) CameraData; samples: of its chains."""
    inputs = [scene, camera, image_size(size), samples, out]
    lobes = Lobes.TRACED if out.traces_gloss else Lobes.EVEN
    if samples.lobes:
        lobes, features = Lobes.FOLLOWED, replace(features, specular=True)
    launch(primary_ray_kernel(features, lobes), size[0] * size[1], inputs, out.face.device)
