"""The brightest shading points of a small picture, and what rays of theirs find."""

from itertools import product

import numpy as np
import warp as wp
from pipeline import Pipeline
from scenes import column, slats

from gpu.correction.adaptive_ray_sampling import RAYS
from gpu.correction.adaptive_rays import BINOMIAL, BrightPoints
from gpu.correction.brightness import MeanBrightness
from gpu.denoise.atrous import ATROUS_PARAMETERS
from gpu.gbuffer.edge_stopping import EDGE_STOPPING_PARAMETERS
from gpu.indirect.irradiance import CHECKS
from gpu.scene.types import Doubles, Ints

SEEDS = 200
SIZE = (16, 12)


class Bright:
    """The brightest of a pipeline's SPs. dim: how bright the picture is taken to be, so that many are bright."""

    def __init__(self, fuzzy: Pipeline, capacity: int, dim: float = 0.2) -> None:
        self.fuzzy, self.view, self.dim = fuzzy, fuzzy.view, dim
        self.points = BrightPoints(fuzzy.size, capacity, fuzzy.view.device)
        self.picture = MeanBrightness(fuzzy.view.device)

    def trace(self, seed: int = 0) -> Ints:
        """The pixels of those that have rays now."""
        fuzzy, view = self.fuzzy, self.view
        view.seed.fill_(seed)
        dim = column(self.dim * fuzzy.irradiance(), wp.vec3)
        self.picture.find(view.gbuffer, view.shading_points, dim)
        self.points.trace(view.scene, view.gbuffer, view.shading_points, fuzzy.known, view.indirect, view.seed,
                          self.picture)  # fmt: skip
        return np.asarray(self.points.pixels.numpy()[: self.points.count.numpy()[0]])

    def take(self, told: Doubles, known: Doubles, shown: Doubles, frames: int) -> tuple[Doubles, Doubles]:
        """Light and irradiance (pixel, 3) once the rays are taken into `known` light and the irradiance `shown`."""
        light, irradiance = column(known, wp.vec3), column(shown, wp.vec3)
        before = wp.full(self.view.pixels, frames, dtype=int, device=self.view.device)
        self.points.take(self.view.gbuffer, self.fuzzy.lights, column(told, wp.vec3), before, light, irradiance)
        return light.numpy().astype(np.float64), irradiance.numpy().astype(np.float64)

    def found(self, frames: int = 0) -> Doubles:
        """What the rays say that the light is, (pixel, 3)."""
        told, none = self.fuzzy.irradiance(), np.zeros((self.view.pixels, 3))
        return self.take(told, none, none, frames)[0] * (RAYS + CHECKS * (frames + 1)) / RAYS

    def shared(self, pixels: Ints, lacking: Doubles, told: Doubles) -> Doubles:
        """What SPs at `pixels` lack as those of them around each tell it, (place, 3); told, lacking (pixel, 3)."""
        gbuffer, (width, height), brightness = self.view.gbuffer, self.fuzzy.size, told.mean(axis=1)
        position, normal, geometric_normal = (
            getattr(gbuffer, name).numpy() for name in ("position", "normal", "geometric_normal")
        )
        means = []
        for pixel in pixels:
            row, column = divmod(pixel, width)
            weights = np.zeros(self.view.pixels)
            for across, down in product(range(-2, 3), repeat=2):
                other = (row + down) * width + column + across
                if not (0 <= row + down < height and 0 <= column + across < width and other in pixels):
                    continue
                off = geometric_normal[pixel] @ (position[other] - position[pixel])
                limit = ATROUS_PARAMETERS.plane_tolerance * gbuffer.spacing.numpy()[pixel] * 2
                edge_stopping_weight = max(
                    normal[pixel] @ normal[other], 0.0
                ) ** EDGE_STOPPING_PARAMETERS.normal_power * np.exp(-((off / limit) ** 2))
                unlike = abs(brightness[other] - brightness[pixel]) / (
                    ATROUS_PARAMETERS.guide_tolerance * brightness[pixel]
                )
                weights[other] = BINOMIAL[abs(across)] * BINOMIAL[abs(down)] * edge_stopping_weight * np.exp(-unlike)
            means.append(weights @ lacking / weights.sum())
        return np.array(means)


def picture_of(*, far_field_sums: bool) -> Pipeline:
    """Every VPL a cluster of its own: then light of members and of clusters is the same."""
    device_scene, camera, _ = slats()
    return Pipeline(
        device_scene, camera, SIZE, sp_clusters=80, vpls=250, vpl_clusters=1000, far_field_sums=far_field_sums
    )
