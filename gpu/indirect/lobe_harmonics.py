"""Specular lobes in spherical harmonics: 2009 paper, section 3.4."""

import warp as wp

from gpu.core.constants import GOLDEN_RATIO
from gpu.device_scene.bsdf import sample_specular, specular_lobe
from gpu.device_scene.surface import Surface
from gpu.indirect.spherical_harmonics import Harmonics, harmonics_at

# Directions by which a lobe is projected, the same for all: harmonics of four bands are smooth.
DIRECTIONS = wp.constant(24)


@wp.struct
class LobeHarmonics:
    """What a lobe reflects of each harmonic of radiance: at normal incidence for f0 of 1, and what Schlick's rise adds
    for f90 of 1 and takes from f0.
    """

    whole: Harmonics
    rise: Harmonics


@wp.func
def lobe_harmonics(surface: Surface, view: wp.vec3) -> LobeHarmonics:
    """The specular lobe of `surface` that is reflected to unit `view`, cosine and all."""
    lobe = LobeHarmonics()
    whole = Harmonics()
    rise = Harmonics()
    number = int(0)  # of a loop that is not unrolled
    while number < DIRECTIONS:
        x = (float(number) + 0.5) / float(DIRECTIONS)
        turn = GOLDEN_RATIO * float(number)
        sample = sample_specular(surface, view, x, turn - wp.floor(turn))
        cos_light = wp.dot(surface.normal, sample.direction)
        if sample.density > 0.0 and cos_light > 0.0:
            half = wp.normalize(view + sample.direction)
            weight = specular_lobe(surface, view, sample.direction, half) * cos_light / sample.density
            values = harmonics_at(sample.direction) * (weight / float(DIRECTIONS))
            whole += values
            rise += values * wp.pow(1.0 - wp.clamp(wp.dot(view, half), 0.0, 1.0), 5.0)
        number += 1
    lobe.whole = whole
    lobe.rise = rise
    return lobe


@wp.func
def reflected_channel(lobe: LobeHarmonics, f0: float, f90: float, radiance: Harmonics) -> float:
    """What the lobe reflects of `radiance` in one channel [W/m²/sr]; what rings below zero is none."""
    return wp.max(wp.dot(lobe.whole, radiance) * f0 + wp.dot(lobe.rise, radiance) * (f90 - f0), 0.0)
