"""A rendered frame and what it took."""

from dataclasses import dataclass, field, replace

import numpy as np
import warp as wp

from gpu.core.lane import Lane
from gpu.core.staging_buffer import StagingBuffer
from gpu.scene.types import Bytes, Floats


@dataclass(frozen=True)
class FrameStats:
    """Times of the stages [ms] in their order, counts of what the picture is made of, and what was skipped, by name.

    On a GPU the rays of `direct` and `near` run beside other stages; the times of these two are the frame's wait for
    them.

    skips has the names of gpu.settings.Skips; each counts what was not done, so 0 where there was nothing to skip or
    the switch is off: pixels that were not rendered again (unchanged_camera) or take
    their light from those around them (interpolated), VPLs that were not traced again (unchanged_lights), pairs of
    clusters whose visibility is kept (kept_clusters) or that have no ray (facing_away, shared_weak_rays), shaded pixels
    whose light earlier frames found, too (temporal_reuse), pairs of shaded pixels and VPL clusters too far to be shaded
    one by one (far_field_sums), and 1 for masks, textures or narrow specular lobes that kernels know nothing of
    (absent_alpha, absent_textures, absent_gloss).

    estimates: of a frame with a target, the target and what was expected of the frame's counts (gpu.adaptive.governor),
    by name; how many tries a picture for a wanted error took, of which stage_ms are the sum.
    """

    stage_ms: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    skips: dict[str, int] = field(default_factory=dict)
    estimates: dict[str, float] = field(default_factory=dict)
    steady: bool = True
    host_ms: float | None = None

    def after(self, before: "FrameStats") -> "FrameStats":
        """Those of another try, after the tries `before`, which are not shown."""
        names = {**before.stage_ms, **self.stage_ms}
        times = {name: before.stage_ms.get(name, 0.0) + self.stage_ms.get(name, 0.0) for name in names}
        return replace(self, stage_ms=times, estimates={**self.estimates, "tries": before.estimates["tries"] + 1.0})


@dataclass(frozen=True)
class Frame:
    """An image of `size` (width, height) on the device; it is the renderer's until the next frame overwrites it.

    display: its pixels, which are copied to the host in the `lane` that it was rendered in; None: which are there.
    """

    size: tuple[int, int]
    device_radiance: wp.array
    display: StagingBuffer
    stats: FrameStats
    lane: Lane | None

    @property
    def device_pixels(self) -> wp.array:
        """Display-ready sRGB, (pixel, 3) uint8."""
        return self.display.array

    def radiance(self) -> Floats:
        """Linear Rec. 709 radiance [W/m²/sr], shape (height, width, 3), a copy."""
        width, height = self.size
        return np.array(self.device_radiance.numpy(), np.float32).reshape(height, width, 3)

    def pixels(self) -> Bytes:
        """Display-ready sRGB, shape (height, width, 3) uint8, a copy.

        Frames of other lanes do not delay it: an ordinary copy would wait for what they have on the device.
        """
        width, height = self.size
        if self.lane:
            with self.lane.entered():
                self.display.download()
            self.lane.flight().wait()
        return self.display.host.reshape(height, width, 3).copy()
