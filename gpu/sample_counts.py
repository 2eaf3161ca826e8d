"""The counts of a render: those the user chose, and for the others what suits the device."""

from dataclasses import dataclass
from typing import Protocol

from gpu.settings import RenderSettings


class Device(Protocol):
    """What is asked of a device, such as one of Warp's."""

    @property
    def is_cuda(self) -> bool:
        """Whether it is a GPU."""


@dataclass(frozen=True)
class SampleCounts:
    """Counts with none left open; see RenderSettings."""

    sp_clusters: int
    vpls: int
    vpl_clusters: int
    photons: int
    gather_rays: int
    samples: int
    frames: int
    shadow_map: int


ON_CUDA = SampleCounts(
    sp_clusters=8192,
    vpls=98_304,
    vpl_clusters=2048,
    photons=262_144,
    gather_rays=256,
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
    samples=1,
    frames=16,
    shadow_map=64,
)
PATHS = 64


def sample_counts_of(settings: RenderSettings, device: Device) -> SampleCounts:
    """The counts of `settings`, the open ones chosen for `device`."""
    usual = ON_CUDA if device.is_cuda else ON_CPU
    samples = PATHS if settings.method.refines_by_samples else usual.samples
    return SampleCounts(
        sp_clusters=settings.sp_clusters or usual.sp_clusters,
        vpls=settings.vpls or usual.vpls,
        vpl_clusters=settings.vpl_clusters or usual.vpl_clusters,
        photons=settings.photons or usual.photons,
        gather_rays=settings.gather_rays or usual.gather_rays,
        samples=settings.samples or samples,
        frames=settings.frames or usual.frames,
        shadow_map=settings.shadow_map or usual.shadow_map,
    )
