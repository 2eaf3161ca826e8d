"""How much each VPL of a reflective shadow map matters to what a camera sees (T. Ritschel et al., Making Imperfect
Shadow Maps View-Adaptive, 2011). Line 3 of Algorithm 1 of the 2012 paper.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.intrinsics import float_sum, lanes_of
from gpu.core.parameters import parameters
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.gbuffer import GBuffer
from gpu.lights.light_paths import Vpls
from gpu.lights.reflective_shadow_map import ShadowMaps
from gpu.sampling.halton import halton_point
from gpu.vpl.form_factor import disk_transfer

# Pixels of the picture whose geometry terms are summed: the paper's number.
VIEW_SAMPLES = 256


@wp.struct
@dataclass
class BidirectionalImportanceParameters:
    """area: of the disk that a VPL is taken for, unit space squared, so that what is near it has no term without bound;
    unseen: importance per flux of a VPL that lights none of the samples, since others may see it: where terms are
    about 0.5 this share of clusters goes by flux alone.
    """

    area: float = 0.01
    unseen: float = 0.02


BIDIRECTIONAL_IMPORTANCE_PARAMETERS: BidirectionalImportanceParameters = parameters(BidirectionalImportanceParameters)


@wp.kernel
def view_sample_kernel(
    first: int, gbuffer: GBuffer, image: ImageSize, position: wp.array[wp.vec3], normal: wp.array[wp.vec3]
) -> None:
    """One thread a sample: the point that a pixel of Halton's sequence sees, position and normal (sample,).

    Its normal is 0 where that is nothing.
    """
    sample = first + wp.tid()
    point = halton_point(sample)
    pixel = int(point[1] * float(image.height)) * image.width + int(point[0] * float(image.width))
    position[sample] = gbuffer.position[pixel]
    normal[sample] = wp.where(gbuffer.face[pixel] == NO_HIT, wp.vec3(0.0, 0.0, 0.0), gbuffer.normal[pixel])


@wp.kernel
def bidirectional_importance_kernel(first: int, vpls: Vpls, position: wp.array[wp.vec3], normal: wp.array[wp.vec3],
                                    chosen: BidirectionalImportanceParameters, maps: ShadowMaps, lanes: int,
                                    importance: wp.array[float]) -> None:  # fmt: skip
    """`lanes` threads a VPL: its flux times the mean geometry term of it and the view's samples, visibility aside, and
    times what its map is worth.

    position, normal (sample,): of `view_sample_kernel`; importance (vpl,).
    """
    index = first + wp.tid()
    vpl = index // lanes
    lane = index % lanes
    flux = brightness(vpls.flux[vpl])
    if flux <= 0.0:
        importance[vpl] = 0.0
        return
    total = float(0.0)
    for sample in range(lane, position.shape[0], lanes):
        way = vpls.position[vpl] - position[sample]
        total += disk_transfer(way, normal[sample], vpls.normal[vpl], chosen.area)
    total = float_sum(total, lanes)
    if lane == 0:
        worth = maps.worth[vpl // (maps.side * maps.side)]
        importance[vpl] = worth * flux * (total / float(position.shape[0]) + chosen.unseen)


class BidirectionalImportance:
    """Of VPLs to a picture; its arrays are allocated once."""

    def __init__(self, device: wp.Device) -> None:
        self.device = device
        self._position = wp.zeros(VIEW_SAMPLES, dtype=wp.vec3, device=device)
        self._normal = wp.zeros(VIEW_SAMPLES, dtype=wp.vec3, device=device)

    def run(self, gbuffer: GBuffer, size: tuple[int, int], maps: ShadowMaps, vpls: Vpls, importance: wp.array) -> None:
        """Write the `importance` (vpl,) of the `vpls` of `maps` to the picture of `size` (width, height) that `gbuffer`
        is of.
        """
        samples = [self._position, self._normal]
        launch(view_sample_kernel, VIEW_SAMPLES, [gbuffer, image_size(size), *samples], self.device)
        lanes = lanes_of(self.device, few=True)
        inputs = [vpls, *samples, BIDIRECTIONAL_IMPORTANCE_PARAMETERS, maps, lanes, importance]
        launch(bidirectional_importance_kernel, lanes * vpls.count, inputs, self.device)
