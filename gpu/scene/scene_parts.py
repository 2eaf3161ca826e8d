"""What readers find in files, in the files' own coordinates, and whether it is sound: gpu.scene.assemble makes a Scene
of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gpu.errors import SceneError
from gpu.scene import validate
from gpu.scene.animation.motion import Body, Motion
from gpu.scene.import_options import Axis, ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.types import Camera, Doubles, Environment, Floats, Integers, Light, Material, Sky, Texture


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Triangles of one material in the file's coordinates.

    positions (vertex, 3) float64; triangles (triangle, 3) indices, counter-clockwise seen from the front; normals
    (vertex, 3) or None for flat shading; uvs: one (vertex, 2) array a set; colors (vertex, 4) linear or None;
    material: index into the scene's materials; name: what error messages call it; objects: what users do, `name` where
    there are none; vertex_object (vertex,): which of several each vertex is of; body: what it was before it was placed,
    if it moves.
    """

    positions: Doubles
    triangles: Integers
    normals: Doubles | None = None
    uvs: tuple[Doubles | Floats, ...] = ()
    colors: Doubles | Floats | None = None
    material: int = 0
    name: str = "mesh"
    objects: tuple[str, ...] = ()
    vertex_object: Integers | None = None
    body: Body | None = None

    @property
    def owners(self) -> tuple[tuple[str, ...], Integers]:
        """The names of its objects, and which of them each vertex (vertex,) is of."""
        own = self.vertex_object
        return self.objects or (self.name,), np.zeros(len(self.positions), np.int32) if own is None else own


@dataclass(frozen=True)
class SceneParts:
    """What a reader found in a file, all in the file's own coordinates, axes and unit of length.

    lights: intensity [W/sr], of directional ones irradiance [W/m²], whatever the unit; ignored: what it did not use, by
    name; notes: what is shown otherwise than the file says; up, metres_per_unit: what the file says, None where it says
    nothing; choices: what the options "variant" and "storey" can be; motion: what moves, without its bodies.
    """

    meshes: Sequence[MeshPart]
    materials: Sequence[Material]
    textures: Sequence[Texture] = ()
    lights: Sequence[Light] = ()
    cameras: Sequence[Camera] = ()
    sky: Sky | Environment | None = None
    ignored: Sequence[str] = ()
    notes: Sequence[str] = ()
    up: Axis | None = None
    metres_per_unit: float | None = None
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)
    motion: Motion | None = None


def check_parts(name: str, found: SceneParts, limits: SceneLimits) -> None:
    """Raise SceneError when an array is not finite or refers to what is not there, a number is too large to compute
    with, or a limit is exceeded.
    """
    validate.check_textures(name, found.textures, limits)
    validate.check_materials(name, found.materials, len(found.textures), limits)
    validate.check_lights(name, found.lights, limits)
    validate.check_cameras(name, found.cameras, limits)
    triangles = sum(len(part.triangles) for part in found.meshes)
    validate.check_count(name, "triangles", triangles, limits.max_triangles, "max_triangles")
    for part in found.meshes:
        if not (part.positions.size == 0 or np.abs(part.positions).max() <= validate.FARTHEST):
            validate.check_finite(name, f"{part.name}.positions", part.positions)
            validate.check_size(name, f"{part.name}.positions", part.positions, validate.FARTHEST)
        validate.check_indices(name, f"{part.name}.triangles", part.triangles, len(part.positions))
        if not 0 <= part.material < len(found.materials):
            validate.check_indices(name, f"{part.name}.material", np.array([part.material]), len(found.materials))
        for number, uv in enumerate(part.uvs):
            validate.check_finite(name, f"{part.name}.uvs[{number}]", uv)
        if part.colors is not None:
            validate.check_finite(name, f"{part.name}.colors", part.colors)
        for what in (part.normals, part.colors, *part.uvs):
            if what is not None and len(what) != len(part.positions):
                raise SceneError(name, part.name, f"{len(what)} values of an attribute, {len(part.positions)} vertices")


def check_choices(name: str, choices: Mapping[str, Sequence[str]], options: ImportOptions) -> None:
    """Raise SceneError for a variant or storey that the file does not have."""
    for kind, wanted in (("variant", [options.variant] if options.variant else []), ("storey", options.storeys)):
        offered = choices.get(kind, ())
        if wrong := [one for one in wanted if one not in offered]:
            there = f"it has {', '.join(offered)}" if offered else "it has none"
            raise SceneError(name, "", f"there is no {kind} {wrong[0]!r:.80} in it; {there}")
