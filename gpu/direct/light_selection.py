"""Which lights the surfaces in each tile of the picture see, learnt by a few rays, so that direct light samples those.

By power alone most samples go to what is hidden: to a bulb in its shade, and from all of a room to the sky that a few
places see through a window. The rare samples of other lights then count for much. Learning where light arrives, and
mixing that with what is known before, is as in Vévoda et al., Bayesian Online Regression for Adaptive Direct
Illumination Sampling (2018); what is learnt here decides only how much noise there is.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.panes import transmittance
from gpu.device_scene.specialisation import made_for, specialisation
from gpu.gbuffer.gbuffer import GBuffer
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import BELOW_ONE, sobol_pair

# Pixels of a tile's side, and bins of all light, of equal power each: neighbouring emitters of the table.
TILE = wp.constant(8)
BIN_BITS = wp.constant(6)
BINS = wp.constant(1 << int(BIN_BITS))
IN_BIN = wp.constant(wp.uint32(32 - int(BIN_BITS)))
# Of a square of tiles each has rays to another part of the bins.
SQUARE = wp.constant(2)
PROBES = wp.constant(int(BINS) // int(SQUARE) ** 2)
# Among the samples of gpu.sampling.sobol.sobol_pair, beside those of other stages.
PROBE_PAIR = wp.constant(96)
# Pixels of a picture that has some: tiles of smaller ones see too much of a room each, and it may get noisier.
LEAST_PIXELS = 1 << 15
# What an array for each tile and bin takes of a pixel, with those of probes [bytes].
SELECTION_PIXEL_BYTES = 10


@wp.struct
@dataclass
class SelectionParameters:
    """How far what probes find is believed.

    reach: tiles on each side whose probes a tile has, too; by_power: share of the samples that go by power alone, as
    probes miss some light; least_visible: that a bin counts as, of which nothing was seen.
    """

    reach: int = 3
    by_power: float = 0.7
    least_visible: float = 0.3


SELECTION_PARAMETERS: SelectionParameters = parameters(SelectionParameters)


@wp.struct
class LightSelection:
    """How samples of light are chosen, by tile and bin, (tile × BINS,) each, tiles row by row.

    columns: tiles in a row, 0 where nothing is learnt; ends: the share of samples that go to bins up to
    this one; visible: the square root of the share of its light that arrives, which the deviation of samples is in
    proportion to.
    """

    columns: int
    ends: wp.array[float]
    visible: wp.array[float]


@wp.struct
class ProbedLight:
    """What probes found, (tile × PROBES,) each: brightness of the irradiance unshadowed, and of what arrives; −1 where
    there is no surface.
    """

    sent: wp.array[float]
    arrived: wp.array[float]


@wp.struct
class LightPick:
    """A fraction of 2³² that chooses an emitter by power, the density with which it was picked, 1 in the mean, and
    LightSelection's `visible` of its bin.
    """

    value: wp.uint32
    density: float
    visible: float


@wp.func
def bins_at(selection: LightSelection, pixel: int, width: int) -> int:
    """Where the bins of a pixel's tile begin; width: of the image."""
    return (pixel // width // TILE * selection.columns + pixel % width // TILE) * BINS


@wp.func
def learnt_pick(selection: LightSelection, bins: int, x: float) -> LightPick:
    """The choice that number `x`, in [0, 1), makes of what is learnt of a tile; bins: as `bins_at` tells."""
    index = int(0)
    step = int(BINS) // 2
    while step > 0:
        if selection.ends[bins + index + step - 1] <= x:
            index += step
        step = step // 2
    below = float(0.0)
    if index > 0:
        below = selection.ends[bins + index - 1]
    share = selection.ends[bins + index] - below
    inside = wp.clamp((x - below) / share, 0.0, BELOW_ONE)
    pick = LightPick()
    pick.value = (wp.uint32(index) << IN_BIN) + wp.uint32(inside * wp.static(float(1 << int(IN_BIN))))
    pick.density = share * float(BINS)
    pick.visible = selection.visible[bins + index]
    return pick


@made_for("masks", "alpha", "cutouts", "textures", "panes", "environment", "translucent", "part_glass")
def probe_lights_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise, translucent = specialisation(features), features.translucent

    @wp.kernel(module="unique")
    def probe_lights_kernel(first: int, scene: SceneData, table: LightTable, gbuffer: GBuffer, image: ImageSize,
                            columns: int, seed: int, probed: ProbedLight) -> None:  # fmt: skip
        """One thread a probe: a ray from one of its tile's pixels to a sample of one bin's light. All frames of a
        seed have the same, so that their samples go on complementing each other.
        """
        probe = first + wp.tid()
        probed.sent[probe] = -1.0
        probed.arrived[probe] = -1.0
        tile = probe // PROBES
        part = tile // columns % SQUARE * SQUARE + tile % columns % SQUARE
        index = probe % PROBES * SQUARE * SQUARE + part
        place = sobol_pair(probe, PROBE_PAIR, seed)
        column = tile % columns * TILE + int(place.x * float(TILE))
        row = tile // columns * TILE + int(place.y * float(TILE))
        if column >= image.width or row >= image.height:
            return
        pixel = row * image.width + column
        if gbuffer.face[pixel] == NO_HIT:
            return
        scene = specialise(scene)
        pick = sobol_pair(probe, PROBE_PAIR + 1, seed)
        point = sobol_pair(probe, PROBE_PAIR + 2, seed)
        position = gbuffer.position[pixel]
        normal = gbuffer.geometric_normal[pixel]
        value = (wp.uint32(index) << IN_BIN) + (pick.a >> wp.uint32(BIN_BITS))
        sample = sample_light(scene, table, table.sampled, position, value, point)
        cosine = wp.dot(gbuffer.normal[pixel], sample.direction)
        if wp.static(translucent) and gbuffer.translucent:
            behind = cosine < 0.0 and largest(gbuffer.through[pixel]) > 0.0
            cosine = wp.where(behind, -cosine, cosine)
            normal = wp.where(behind, -normal, normal)
        sent = brightness(sample.irradiance) * wp.max(cosine, 0.0)
        arrived = float(0.0)
        if sent > 0.0 and wp.isfinite(sent) and wp.dot(normal, sample.direction) > 0.0:
            arrived = sent * brightness(transmittance(scene, position, normal, sample.point, sample.normal))
        probed.sent[probe] = sent
        probed.arrived[probe] = arrived

    return probe_lights_kernel


@wp.kernel
def gather_probes_kernel(first: int, columns: int, rows: int, chosen: SelectionParameters, probed: ProbedLight,
                         selection: LightSelection) -> None:  # fmt: skip
    """One thread a tile's bin: the mean light that probes of the tiles around found of it, still in place of `ends`."""
    item = first + wp.tid()
    tile = item // BINS
    index = item % BINS
    part = index % (SQUARE * SQUARE)
    # The first tiles in reach that have probes of this bin.
    left = tile % columns - chosen.reach
    left += (part - left) & 1
    top = tile // columns - chosen.reach
    top += (part // SQUARE - top) & 1
    number = float(0.0)
    sent = float(0.0)
    arrived = float(0.0)
    for y in range(wp.max(top, part // SQUARE), wp.min(tile // columns + chosen.reach + 1, rows), SQUARE):
        for x in range(wp.max(left, part % SQUARE), wp.min(tile % columns + chosen.reach + 1, columns), SQUARE):
            probe = (y * columns + x) * PROBES + index // (SQUARE * SQUARE)
            if probed.sent[probe] >= 0.0:
                number += 1.0
                sent += probed.sent[probe]
                arrived += probed.arrived[probe]
    selection.ends[item] = arrived / wp.max(number, 1.0)
    visible = float(1.0)
    if sent > 0.0:
        visible = wp.max(wp.sqrt(arrived / sent), chosen.least_visible)
    selection.visible[item] = visible


@wp.kernel
def select_lights_kernel(first: int, by_power: float, selection: LightSelection) -> None:
    """One thread a tile: the choice among its bins, by power and, as far as any has light, by what arrives of it."""
    bins = (first + wp.tid()) * BINS
    total = float(0.0)
    for index in range(BINS):
        total += selection.ends[bins + index]
    end = float(0.0)
    even = wp.where(total > 0.0, by_power, 1.0) / float(BINS)
    for index in range(BINS):
        end += even
        if total > 0.0:
            end += selection.ends[bins + index] / total * (1.0 - by_power)
        selection.ends[bins + index] = end
    selection.ends[bins + BINS - 1] = 1.0


class LightProbes:
    """Learns the selection for pictures of `size` (width, height), each anew; its arrays are allocated once."""

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self._size = size
        self._rows, columns = (-(-side // int(TILE)) for side in reversed(size))
        tiles = self._rows * columns
        self._probed, self.selection = ProbedLight(), LightSelection()
        self._probed.sent = wp.zeros(tiles * int(PROBES), dtype=float, device=device)
        self._probed.arrived = wp.zeros_like(self._probed.sent)
        self.selection.columns = columns
        self.selection.ends = wp.zeros(tiles * int(BINS), dtype=float, device=device)
        self.selection.visible = wp.zeros_like(self.selection.ends)

    def run(self, scene: SceneData, table: LightTable, gbuffer: GBuffer, seed: int,
            features: SceneFeatures = EVERYTHING) -> None:  # fmt: skip
        """Learn the `selection` for what is in `gbuffer`, by rays to samples of `seed`."""
        probed, selection, chosen = self._probed, self.selection, SELECTION_PARAMETERS
        device, columns = probed.sent.device, selection.columns
        inputs = [scene, table, gbuffer, image_size(self._size), columns, seed, probed]
        launch(probe_lights_kernel(features), len(probed.sent), inputs, device)
        inputs = [columns, self._rows, chosen, probed, selection]
        launch(gather_probes_kernel, len(selection.ends), inputs, device)
        launch(select_lights_kernel, self._rows * columns, [chosen.by_power, selection], device)
