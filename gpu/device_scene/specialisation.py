"""What a scene is known not to have, told to kernels.

Functions ask while they run, as in `if scene.textured`. A kernel that is made for some features writes over what they
ask with a constant first, and the code of all that it calls is made without the rest (gpu.core.code_generation).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, wraps
from types import SimpleNamespace
from typing import TypeVarTuple

import warp as wp

from gpu.core.code_generation import tell_constants
from gpu.core.device import RAY_REGISTERS
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.surface import Surface

# What it takes to read a surface's look: whether rays pass its triangle, its textures, and what seldom is there.
LOOK = ("masks", "alpha", "cutouts", "textures", "sheen", "films", "grain", "translucent", "part_glass")

# What kernels are told by constants alone. The compiler for CPUs follows these into few functions: kernels for scenes
# without it are no faster there, and those for all scenes are compiled once.
TOLD_BY_CONSTANTS = (
    "masks", "alpha", "cutouts", "blend", "sheer", "textures", "gloss", "glass", "panes", "one_sided", "backdrop",
    "environment",
)  # fmt: skip

Rest = TypeVarTuple("Rest")
KernelMaker = Callable[[SceneFeatures, *Rest], wp.Kernel]


def made_for(*names: str) -> Callable[[KernelMaker[*Rest]], KernelMaker[*Rest]]:
    """Have one kernel made for all scenes that do not differ in these features; of the others it has all, and of those
    that are told by constants, too, where there are to be none.
    """

    def decorate(make: KernelMaker[*Rest]) -> KernelMaker[*Rest]:
        @cache
        def kernel_of(told: tuple[bool, ...], *rest: *Rest) -> wp.Kernel:
            features = replace(EVERYTHING, **dict(zip(names, told, strict=True)))
            kernel = make(features, *rest)
            tell_constants(kernel, SceneData, _absent(features))
            return kernel

        @wraps(make)
        def narrowed(features: SceneFeatures, *rest: *Rest) -> wp.Kernel:
            all_told = {} if features.constants else dict.fromkeys(TOLD_BY_CONSTANTS, True)
            told = replace(features, **all_told)
            return kernel_of(tuple(getattr(told, name) for name in names), *rest)

        return narrowed

    return decorate


def masks_of(scene: SceneData) -> SceneFeatures:
    """All features, but masks and part glass only as `scene` has them for rays of a renderer (DeviceScene.view)."""
    masks = scene.alpha or scene.masked_count > 0
    return replace(EVERYTHING, masks=masks, alpha=scene.alpha, cutouts=scene.cutouts, part_glass=scene.part_glass)


def cutouts_of(scene: SceneData) -> SceneFeatures:
    """All features, but no cutouts and part glass where rays of a renderer test masks and find none."""
    return replace(EVERYTHING, cutouts=scene.cutouts or not scene.alpha, part_glass=scene.part_glass)


def part_glass_of(scene: SceneData) -> SceneFeatures:
    """All features, but part glass only as `scene` has it for rays of a renderer."""
    return replace(EVERYTHING, part_glass=scene.part_glass)


def ray_registers(features: SceneFeatures) -> int | None:
    """The most registers of a kernel that only asks what its rays meet: part glass has surfaces looked at, which takes
    so many that few threads run at once. None: as many as it takes.
    """
    return RAY_REGISTERS if features.part_glass else None


@cache
def surface_specialisation(features: SceneFeatures) -> wp.Function:
    """A function (Surface) -> Surface, to be called first in one that is not inlined, where nothing is known else."""

    @wp.func
    def specialise_surface(given: Surface) -> Surface:
        surface = given
        if wp.static(not features.sheen):
            surface.sheen = wp.vec3(0.0, 0.0, 0.0)
        if wp.static(not features.films):
            surface.film = 0.0
        if wp.static(not features.grain):
            surface.grain = wp.vec3(0.0, 0.0, 0.0)
        if wp.static(not features.translucent):
            surface.through = wp.vec3(0.0, 0.0, 0.0)
        return surface

    return specialise_surface


@cache
def specialisation(features: SceneFeatures) -> wp.Function:
    """A function (SceneData) -> SceneData, to be called first in a kernel for scenes of these `features`."""

    @wp.func
    def specialise(given: SceneData) -> SceneData:
        scene = given
        if wp.static(not features.masks):
            scene.masked_count = 0
        if wp.static(not features.alpha):
            scene.ignore_alpha = True
        if wp.static(not features.cutouts):
            scene.cutouts = False
        if wp.static(not features.blend):
            scene.blended = False
        if wp.static(not features.sheer):
            scene.sheer = False
        if wp.static(not features.textures):
            scene.textured = False
        if wp.static(not features.gloss):
            scene.glossy = False
        if wp.static(not features.glass):
            scene.transmissive = False
        if wp.static(not features.panes):
            scene.pane_count = 0
        if wp.static(not features.one_sided):
            scene.one_sided = False
        if wp.static(not features.backdrop):
            scene.backdrop_count = 0
        if wp.static(not features.environment):
            scene.has_environment = False
        if wp.static(not features.specular):
            scene.specular = False
        if wp.static(not features.coats):
            scene.coated = False
        if wp.static(not features.sheen):
            scene.sheened = False
        if wp.static(not features.films):
            scene.filmed = False
        if wp.static(not features.grain):
            scene.grained = False
        if wp.static(not features.translucent):
            scene.translucent = False
        if wp.static(not features.dispersion):
            scene.dispersive = False
        if wp.static(not features.part_glass):
            scene.part_glass = False
        return scene

    return specialise


def _absent(features: SceneFeatures) -> dict[str, bool | int]:
    """The fields that `specialisation` writes, and what."""
    scene = SimpleNamespace()
    specialisation(features).func(scene)
    return vars(scene)
