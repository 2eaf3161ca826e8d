"""What the last frame of a walk saw, and where in it the points were that this frame sees.

Light that does not depend on the view belongs to a surface and stays true while the lights do. So what a frame's few
rays find goes into a mean with those of the frames before, looked up where their camera saw the same point: reverse
reprojection (D. Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, 2007), the temporal
part of C. Schied et al. 2017. Beyond the 2022 paper, which leaves temporal coherence to future work.
"""

import warp as wp

from gpu.core.image_size import image_of
from gpu.gbuffer.camera_rays import CameraData, image_point
from gpu.gbuffer.edge_stopping import surface_weight
from gpu.gbuffer.gbuffer import GBuffer

# A mean of so many frames, from which on older ones fade out, has little noise; each frame that hands it on blurs it a
# little.
MOST_FRAMES = wp.constant(8)
# Of what surrounds a point in the frame before, the least share that must be of its surface. At edges the rest is not,
# and light comes from farther inside: frames count by that share, so that these forget sooner.
LEAST_SHARE = wp.constant(0.5)
# How far off its plane a point is still of a surface, in spacings a step: slats and cracks are as deep as a pixel.
PLANE_TOLERANCE = wp.constant(0.5)


@wp.struct
class PreviousFrameData:
    """What the last frame saw: camera (1,); position, normal (pixel,): of its SPs, in unit space."""

    camera: wp.array[CameraData]
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]


@wp.struct
class BilinearTap:
    """One of the four pixels of the last frame around a point, and its share in what surrounds that."""

    pixel: int
    share: float


@wp.func
def bilinear_tap(past: PreviousFrameData, frames: wp.array[int], gbuffer: GBuffer, pixel: int, place: wp.vec2, corner:
int, step: int,
        width: int, height: int) -> BilinearTap:  # fmt: skip
    """Pixel `corner`, 0 … 3, of those around the `place` of this frame's `pixel` in the last one, `step` pixels apart.

    frames (pixel,): how many frames the light of the last one's pixels is the mean of; where 0, their share is 0.
    """
    x = place[0] / float(step)
    y = place[1] / float(step)
    column = int(wp.floor(x)) + corner % 2
    row = int(wp.floor(y)) + corner // 2
    found = BilinearTap()
    share = (1.0 - wp.abs(x - float(column))) * (1.0 - wp.abs(y - float(row)))
    column *= step
    row *= step
    if column >= 0 and column < width and row >= 0 and row < height:
        found.pixel = row * width + column
        if frames[found.pixel] > 0:
            way = past.position[found.pixel] - gbuffer.position[pixel]
            limit = PLANE_TOLERANCE * gbuffer.spacing[pixel] * float(step)
            alike = surface_weight(
                gbuffer.normal[pixel], gbuffer.geometric_normal[pixel], way, past.normal[found.pixel], limit
            )
            found.share = share * alike
    return found


@wp.func
def previous_place(past: PreviousFrameData, position: wp.vec3, width: int, height: int) -> wp.vec2:
    """Where `position` was in the last frame [pixels]."""
    return image_point(past.camera[0], position, image_of(width, height))


@wp.func
def blend(value: wp.vec3, mean: wp.vec3, frames: int, most: int) -> wp.vec3:
    """The mean of `frames` frames with one more, of `most` about."""
    if frames == 0:
        return value
    return mean + (value - mean) / float(wp.min(frames + 1, most))


class PreviousFrame:
    """What a view's last frame saw; `data` is what kernels take. Arrays are allocated once."""

    def __init__(self, pixels: int, device: wp.Device) -> None:
        self.data = PreviousFrameData()
        self.data.camera = wp.zeros(1, dtype=CameraData, device=device)
        self.data.position = wp.zeros(pixels, dtype=wp.vec3, device=device)
        self.data.normal = wp.zeros(pixels, dtype=wp.vec3, device=device)

    def keep(self, gbuffer: GBuffer, camera: wp.array) -> None:
        """Keep what this frame saw for the next one; camera: (1,) CameraData that it was seen by."""
        wp.copy(self.data.camera, camera)
        wp.copy(self.data.position, gbuffer.position)
        wp.copy(self.data.normal, gbuffer.normal)
