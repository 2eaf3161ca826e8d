"""A still view's frames averaged into one picture: anti-aliased, and without the error of any one light set.

Frame n looks through a place of its own in the pixels and has samples of its own; light paths are new every few frames
(gpu.methods). So the mean converges to what infinitely many samples would give, averaged over each pixel.
"""

import warp as wp

from gpu.core.device import launch

# The R2 sequence (M. Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018): 1/g and 1/g² for the root
# g of g³ = g + 1. Its point 0 is the pixel's centre.
R2 = (0.7548776662466927, 0.5698402909980532)


def pixel_place(sample: int) -> tuple[float, float]:
    """Where in [0, 1)² of each pixel the rays of frame `sample` go through."""
    x, y = ((0.5 + sample * step) % 1.0 for step in R2)
    return x, y


@wp.kernel
def average_frames_kernel(first: int, radiance: wp.array[wp.vec3], share: float, mean: wp.array[wp.vec3]) -> None:
    """One thread a pixel: takes one more radiance, which has a `share` of it, into a mean. That keeps its precision."""
    pixel = first + wp.tid()
    value = radiance[pixel]
    if share < 1.0:
        value = mean[pixel] + (value - mean[pixel]) * share
    mean[pixel] = value


class Accumulation:
    """The mean of a view's frames so far: `mean` (pixel,) linear radiance [W/m²/sr], of `samples` frames of some weight
    each.
    """

    def __init__(self, pixels: int, device: wp.Device) -> None:
        self.samples, self._weight = 0, 0.0
        self.mean = wp.zeros(pixels, dtype=wp.vec3, device=device)

    def restart(self) -> None:
        """Forget all frames: another view."""
        self.samples, self._weight = 0, 0.0

    def add(self, radiance: wp.array, weight: float = 1.0) -> None:
        """Take in one more frame, radiance (pixel,)."""
        self._weight += weight
        launch(average_frames_kernel, len(self.mean), [radiance, weight / self._weight, self.mean], self.mean.device)
        self.samples += 1
