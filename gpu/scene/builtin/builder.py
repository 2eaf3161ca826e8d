"""Collects the shapes of a built-in scene by material and assembles them into a Scene.

Its images, which take as long as all shapes do, are made side by side.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from os import cpu_count

import numpy as np
from numpy.typing import ArrayLike

from gpu.scene.animation.motion import STILL, Animation, Body, MorphTarget, Motion
from gpu.scene.animation.pose import at_rest, in_world
from gpu.scene.assemble import assemble
from gpu.scene.builtin.shape import Shape, join
from gpu.scene.builtin.textures import LEAST_ALBEDO, MOST_ALBEDO, palette
from gpu.scene.colors import srgb_to_linear
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Bytes, Camera, Light, Material, Rgb, Scene, Sky, Texture, TextureSlot

IMAGES_AT_ONCE = min(8, cpu_count() or 1)  # which take up to 100 MB each


class Builder:
    """A scene under construction, in metres. Materials are called by name: the last one made with it."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._materials: dict[str, int] = {}
        self._made: list[tuple[Material, list[Shape]]] = []
        self._images: list[tuple[str, Callable[[], Bytes]]] = []
        self._moving: list[tuple[MeshPart, Body]] = []
        self._frame: tuple[float, Sequence[float]] | None = None

    def paints(self, paints: str) -> None:
        """Make a material of each "name #rrggbb roughness, …" (sRGB), kept within the albedos of textures."""
        for paint in paints.split(", "):
            name, colour, roughness = paint.rsplit(" ", 2)
            albedo = np.clip(srgb_to_linear(palette(colour)[0] * 255.0), LEAST_ALBEDO, MOST_ALBEDO)
            self.material(Material(name, base_color=(*albedo.tolist(), 1.0), roughness=float(roughness)))

    def light(self, name: str, radiance: Rgb) -> None:
        """Make a material that emits `radiance` [W/m²/sr] from its front."""
        self.material(Material(name, base_color=(0.6, 0.6, 0.6, 1.0), emission=radiance))

    def textured(
        self, name: str, image: Callable[[], Bytes], metres: Sequence[float] = (1.0, 1.0), roughness: float = 0.6
    ) -> None:
        """Make a material that shows what `image` makes, one repeat of which covers `metres` (along u, along v)."""
        self._images.append((name, image))
        slot = TextureSlot(len(self._images) - 1, 0, (1.0 / metres[0], 0.0, 0.0, 0.0, 1.0 / metres[1], 0.0))
        self.material(Material(name, base_color_slot=slot, roughness=roughness))

    def material(self, material: Material) -> None:
        """Make a material."""
        self._materials[material.name] = len(self._made)
        self._made.append((material, []))

    def frame(self, degrees: float, origin: Sequence[float]) -> "Builder":
        """The same scene, in which what is added is turned about the vertical by `degrees`, then moved to `origin`."""
        view = copy(self)
        view._frame = (degrees, origin)
        return view

    def add(
        self, names: str, shapes: Shape | Sequence[Shape], places: ArrayLike | None = None, degrees: ArrayLike = 0.0
    ) -> None:
        """Put `shapes` of the materials `names` ("one, two, …", or one for all) at each of `places` (see Shape.at)."""
        parts = [shapes] if isinstance(shapes, Shape) else list(shapes)
        materials = names.split(", ")
        for name, part in zip(materials * len(parts) if len(materials) == 1 else materials, parts, strict=True):
            shape = part if places is None else part.at(places, degrees)
            if self._frame is not None:
                shape = shape.at(self._frame[1], self._frame[0])
            self._made[self._materials[name]][1].append(shape)

    def add_moving(self, name: str, s: Shape, targets: Sequence[MorphTarget], weights: Sequence[float]) -> None:
        """Put a shape of the material `name`, which `weights` of `targets` change; its node's number counts from 0."""
        node, place = len(self._moving), np.eye(4)[None]
        body = Body(node, s.positions, s.normals, s.triangles.astype(np.int64), place, tuple(targets), tuple(weights))
        number = self._materials[name]
        part = MeshPart(s.positions, s.triangles, s.normals, (s.uvs,), material=number, name=name, body=body)
        self._moving.append((part, body))

    def scene(
        self,
        cameras: Sequence[Camera],
        lights: Sequence[Light] = (),
        sky: Sky | None = None,
        animations: Sequence[Animation] = (),
    ) -> Scene:
        """The finished scene."""
        parts, materials, motion = [], [material for material, _ in self._made], self._motion(animations)
        for number, (material, shapes) in enumerate(self._made):
            if not shapes:
                continue
            s = join(shapes)
            parts.append(MeshPart(s.positions, s.triangles, s.normals, (s.uvs,), material=number, name=material.name))
        if motion is not None:
            pose = at_rest(motion)
            parts += [in_world(part, body, pose) for part, body in self._moving]
        with ThreadPoolExecutor(IMAGES_AT_ONCE) as threads:
            textures = list(threads.map(lambda it: Texture(it[0], it[1](), srgb=True), self._images))
        found = SceneParts(parts, materials, textures, lights, cameras, sky, up="y", metres_per_unit=1.0, motion=motion)
        return assemble(self._name, found)

    def _motion(self, animations: Sequence[Animation]) -> Motion | None:
        """Of as many nodes as shapes move, each where the scene is."""
        count = len(self._moving)
        still, places = np.full(count, STILL, np.int32), np.tile(np.eye(4), (count, 1, 1))
        return Motion(still, places, np.zeros((count, 10)), tuple(animations)) if animations else None
