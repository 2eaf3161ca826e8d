"""The counts of a render: those the user chose, and for the others what suits the device."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol

from gpu.settings import Quality, RenderSettings


class Device(Protocol):
    """What is asked of a device, such as one of Warp's."""

    @property
    def is_cuda(self) -> bool:
        """Whether it is a GPU."""


class Surfaces(Protocol):
    """What is asked of a scene's features: the web process, which imports no Warp, counts, too."""

    @property
    def lobes(self) -> bool:
        """Whether some are glossy."""

    @property
    def specular(self) -> bool:
        """Whether some are mirrors or glass."""


@dataclass(frozen=True)
class SampleCounts:
    """Counts with none left open; see RenderSettings."""

    sp_clusters: int
    vpls: int
    vpl_clusters: int
    photons: int
    gather_rays: int
    caustic_photons: int
    samples: int
    frames: int
    shadow_map: int


COUNTED = ("sp_clusters", "vpls", "vpl_clusters", "photons", "gather_rays", "caustic_photons")
"""What a quality has more or less of."""

ON_CUDA = SampleCounts(
    sp_clusters=8192,
    vpls=98_304,
    vpl_clusters=2048,
    photons=262_144,
    gather_rays=256,
    caustic_photons=131_072,
    samples=2,
    frames=512,
    shadow_map=128,
)
ON_CPU = SampleCounts(
    sp_clusters=1536,
    vpls=8192,
    vpl_clusters=384,
    photons=16_384,
    gather_rays=64,
    caustic_photons=16_384,
    samples=1,
    frames=16,
    shadow_map=64,
)
PATHS = 64
# Where surfaces shine, whites reflect nearly all light: after four bounces 3 to 5 % of a room's is still on its way.
BOUNCES, GLOSSY_BOUNCES = 4, 6
# Where rays of pixels correct clusters, a GPU's picture has no more SP clusters than one for so many pixels, unless
# they are asked for. More make small pictures no better, and several viewers' slower: of 320×180 by a quarter.
PIXELS_A_CLUSTER = 28


@dataclass(frozen=True)
class QualityFactors:
    """How many times as many clusters, VPLs, photons and paths, and frames averaged, a quality has."""

    counts: float
    frames: float


QUALITY_FACTORS = {
    Quality.DRAFT: QualityFactors(counts=0.25, frames=0.125),
    Quality.BALANCED: QualityFactors(counts=1.0, frames=1.0),
    Quality.BEST: QualityFactors(counts=2.0, frames=4.0),
}
LEAST_SHADOW_MAP = 64


@cache
def usual_counts(quality: Quality, *, cuda: bool) -> SampleCounts:
    """Those of a quality that suit a GPU or, where that is not so, a CPU."""
    usual, factors = ON_CUDA if cuda else ON_CPU, QUALITY_FACTORS[quality]
    scaled = {name: int(factors.counts * getattr(usual, name)) for name in COUNTED}
    side = max(int(factors.counts * usual.shadow_map), LEAST_SHADOW_MAP)
    return replace(usual, **scaled, shadow_map=side, frames=int(factors.frames * usual.frames))


def paths_of(quality: Quality) -> int:
    """Paths a pixel that a frame of a quality has, on any device."""
    return int(QUALITY_FACTORS[quality].counts * PATHS)


def sample_counts_of(settings: RenderSettings, device: Device, pixels: int | None = None) -> SampleCounts:
    """The counts of `settings`, the open ones chosen for `device`; pixels: of a picture, None for a large one."""
    usual = usual_counts(settings.quality, cuda=device.is_cuda)
    if pixels is not None and device.is_cuda and settings.method.corrects_clusters:
        usual = replace(usual, sp_clusters=min(usual.sp_clusters, max(pixels // PIXELS_A_CLUSTER, 1)))
    samples = paths_of(settings.quality) if settings.method.refines_by_samples else usual.samples
    return SampleCounts(
        sp_clusters=settings.sp_clusters or usual.sp_clusters,
        vpls=settings.vpls or usual.vpls,
        vpl_clusters=settings.vpl_clusters or usual.vpl_clusters,
        photons=settings.photons or usual.photons,
        gather_rays=settings.gather_rays or usual.gather_rays,
        caustic_photons=settings.caustic_photons or usual.caustic_photons,
        samples=settings.samples or samples,
        frames=settings.frames or usual.frames,
        shadow_map=settings.shadow_map or usual.shadow_map,
    )


def bounces_of(settings: RenderSettings, has: Surfaces) -> int:
    """The indirect bounces of `settings`; where they are left open, as a scene of these features needs."""
    return settings.bounces or (GLOSSY_BOUNCES if has.lobes or has.specular else BOUNCES)
