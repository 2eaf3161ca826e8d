"""What frames of one size work with: arrays that every frame writes anew, whoever looks. Allocated once.

A GPU's driver takes 15 ms to find a gigabyte, which pictures of many pixels need several of: others have the device in
between.
"""

from dataclasses import replace

import warp as wp

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.staging_buffer import StagingBuffer
from gpu.correction.brightness import MeanBrightness
from gpu.denoise.atrous import Smoothing
from gpu.device_scene.upload import DeviceScene
from gpu.direct.light_selection import LEAST_PIXELS, LightProbes
from gpu.gbuffer.gbuffer import allocate_gbuffer, trace_primary_rays
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.gbuffer.specular_chain import LIKELIER, chain_samples
from gpu.indirect.glossy_reflection import GlossyReflection
from gpu.indirect.irradiance import allocate_indirect
from gpu.settings import EVERY_SKIP, Skips


class FrameArrays:
    """Arrays of an image of `size` (width, height) of a scene, and the scene as its kernels see it.

    area_light (pixel,): direct light of lights with an extent; light_probes: for its samples, None for small pictures
    and where the scene has one lamp at the most; indirect: indirect light, each before it is added; features: what
    kernels must know of the scene; chain_samples: how chains choose in the frame; seed, frame_index (1,): the frame's
    own; numbers: these two and the chains' own index; brightness: of the indirect light; nothing (pixel,): zeros, for
    frames that earlier ones tell nothing; side_smoothing: for what runs beside the stages; gloss: rays of specular
    lobes and frosted glass, None where there are none or the method does without. stride: of the pixels that are
    shaded (gpu.gbuffer.sparse_shading); traces_lobes: whether rays show what these and glass do; shows_coats:
    whether clear coats are seen.
    """

    def __init__(
        self,
        device_scene: DeviceScene,
        size: tuple[int, int],
        *,
        lambertian: bool,
        skip: Skips = EVERY_SKIP,
        stride: int = 1,
        traces_lobes: bool = False,
    ) -> None:
        self.device_scene, self.size, self.device = device_scene, size, device_scene.device
        self.pixels = size[0] * size[1]
        self.scene = device_scene.view(lambertian=lambertian, assume_alpha=not skip.absent_alpha)
        self.features = device_scene.features(
            lambertian=lambertian,
            assume_alpha=not skip.absent_alpha,
            assume_textures=not skip.absent_textures,
            assume_gloss=not skip.absent_gloss,
        )
        self.numbers = StagingBuffer(wp.zeros(3, dtype=int, device=self.device))
        self.seed, self.frame_index = self.numbers.array[:1], self.numbers.array[1:2]
        self.nothing = wp.zeros(self.pixels, dtype=int, device=self.device)
        self.chain_samples = chain_samples(self.device)
        self.chain_samples.frame_index = self.numbers.array[2:]
        self.set_numbers()
        self.numbers.upload()
        self.traces_lobes = self.shows_coats = traces_lobes
        glossy = traces_lobes and self.features.lobes
        self.gloss = GlossyReflection(size, self.device, self.features) if glossy else None
        DEVICE_SHARING.pause()
        self.gbuffer = allocate_gbuffer(self.pixels, self.device, self.features, traces_gloss=glossy)
        self.area_light = wp.zeros(self.pixels, dtype=wp.vec3, device=self.device)
        probed = self.features.lamps and self.pixels >= LEAST_PIXELS
        self.light_probes = LightProbes(size, self.device) if probed else None
        self.smoothing = Smoothing(size, self.device)
        DEVICE_SHARING.pause()
        self.side_smoothing = Smoothing(size, self.device)
        self.indirect = allocate_indirect(self.pixels, self.device)
        DEVICE_SHARING.pause()
        self.shading_points = ShadingPoints(size, stride, self.device)
        self.brightness = MeanBrightness(self.device)

    def set_numbers(self, seed: int = 0, index: int = 0, chain_index: int = LIKELIER) -> None:
        """Write `seed`, `frame_index` and that of `chain_samples` of a frame, which `numbers` uploads."""
        self.numbers.host[:] = seed, index, chain_index

    def trace_primary_rays(self, camera: wp.array) -> None:
        """Fill the G-buffer as `camera` (1,) sees the scene."""
        features = self.features
        if not self.traces_lobes:  # nothing shows it besides: glass is matt then
            features = replace(features, frosted=False)
        if not self.shows_coats:  # nor these: coats are nothing then
            features = replace(features, coats=False)
        trace_primary_rays(self.scene, camera, self.size, self.gbuffer, self.chain_samples, features)
