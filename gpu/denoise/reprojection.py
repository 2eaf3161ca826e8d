"""What the last frame of a walk saw, and where in it the points were that this frame sees.

Light that does not depend on the view belongs to a surface and stays true while the lights do. So what a frame's few
rays find goes into a mean with those of the frames before, looked up where their camera saw the same point: reverse
reprojection (D. Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, 2007), the temporal
part of C. Schied et al. 2017. Beyond the 2022 paper, which leaves temporal coherence to future work.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.gbuffer.camera_rays import CameraData, image_point
from gpu.gbuffer.edge_stopping import is_beside, surface_weight
from gpu.gbuffer.gbuffer import GBuffer, apparent_position


@wp.struct
@dataclass
class ReprojectionParameters:
    """How light is handed on from frame to frame.

    max_frames: a mean of so many, from which on older ones fade out, has little noise, and each frame that hands it on
    blurs it a little; frames_per_roughness: fewer for direct light on specular surfaces, for what a lobe reflects moves
    with the view, the sooner the narrower it is.
    min_share: of what surrounds a point in the last frame, so much must be of its surface. At edges the rest is not,
    and light comes from farther inside: frames count by that share, so that these forget sooner. plane_tolerance: how
    far off its plane a point is still of a surface, in spacings a step: slats and cracks are as deep as a pixel.
    settled_frames, ray_period: of SPs whose light is of so many frames, on even surfaces, one group in so many sends
    rays, and half as many go to lamps; even_light: where light around them differs at most so many times, for at
    contacts light that is handed on fills the dark, which only rays find.
    """

    max_frames: int = 8
    frames_per_roughness: float = 16.0
    min_share: float = 0.5
    plane_tolerance: float = 0.5
    settled_frames: int = 5
    ray_period: int = 3
    even_light: float = 1.5


REPROJECTION_PARAMETERS: ReprojectionParameters = parameters(ReprojectionParameters)


@wp.struct
class PreviousFrameData:
    """What the last frame saw: camera (1,); image: its size; position, normal (pixel,): of its SPs, in unit space."""

    camera: wp.array[CameraData]
    image: ImageSize
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]


@wp.struct
class BilinearTap:
    """One of the four pixels of the last frame around a point, and its share in what surrounds that."""

    pixel: int
    share: float


@wp.func
def bilinear_tap(previous: PreviousFrameData, frames: wp.array[int], gbuffer: GBuffer, pixel: int, place: wp.vec2,
                 corner: int, step: int, tolerance: float) -> BilinearTap:  # fmt: skip
    """Pixel `corner`, 0 … 3, of those around the `place` of this frame's `pixel` in the last one, `step` pixels apart.

    frames (pixel,): how many frames the light of the last one's pixels is the mean of; where 0, their share is 0.
    tolerance: how far off its plane a point is of the surface, in spacings a step.
    """
    x = place[0] / float(step)
    y = place[1] / float(step)
    column = int(wp.floor(x)) + corner % 2
    row = int(wp.floor(y)) + corner // 2
    tap = BilinearTap()
    share = (1.0 - wp.abs(x - float(column))) * (1.0 - wp.abs(y - float(row)))
    column *= step
    row *= step
    if column >= 0 and column < previous.image.width and row >= 0 and row < previous.image.height:
        tap.pixel = row * previous.image.width + column
        if frames[tap.pixel] > 0:
            way = previous.position[tap.pixel] - gbuffer.position[pixel]
            limit = tolerance * gbuffer.spacing[pixel] * float(step)
            normal, geometric_normal = gbuffer.normal[pixel], gbuffer.geometric_normal[pixel]
            if is_beside(gbuffer, pixel, way, step):
                alike = surface_weight(normal, geometric_normal, way, previous.normal[tap.pixel], limit)
                tap.share = share * alike
    return tap


@wp.func
def previous_place(previous: PreviousFrameData, gbuffer: GBuffer, pixel: int) -> wp.vec2:
    """Where the last frame saw the SP of this frame's `pixel` [pixels]; in mirrors and glass that are not plane, about.

    What it saw there is compared with the SP itself.
    """
    return image_point(previous.camera[0], apparent_position(gbuffer, pixel), previous.image)


@wp.func
def blend(value: wp.vec3, mean: wp.vec3, frames: int, most: int) -> wp.vec3:
    """The mean of `frames` frames with one more, of `most` about."""
    if frames == 0:
        return value
    return mean + (value - mean) / float(wp.min(frames + 1, most))


@wp.kernel
def keep_frame_kernel(first: int, gbuffer: GBuffer, camera: wp.array[CameraData], out: PreviousFrameData) -> None:
    """One thread a pixel: keeps where its SP is, the first one the `camera` (1,), too."""
    pixel = first + wp.tid()
    out.position[pixel] = gbuffer.position[pixel]
    out.normal[pixel] = gbuffer.normal[pixel]
    if pixel == 0:
        out.camera[0] = camera[0]


class PreviousFrame:
    """What a viewer's last frame of `size` (width, height) saw; `data` is what kernels take."""

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.data = PreviousFrameData()
        self.data.image = image_size(size)
        self.data.camera = wp.zeros(1, dtype=CameraData, device=device)
        self.data.position = wp.zeros(size[0] * size[1], dtype=wp.vec3, device=device)
        self.data.normal = wp.zeros(size[0] * size[1], dtype=wp.vec3, device=device)

    def keep(self, gbuffer: GBuffer, camera: wp.array) -> None:
        """Keep what this frame saw for the next one; camera: (1,) CameraData that it was seen by."""
        launch(keep_frame_kernel, len(self.data.position), [gbuffer, camera, self.data], camera.device)
