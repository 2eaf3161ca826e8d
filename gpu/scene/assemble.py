"""From mesh parts in a file's coordinates to a Scene in unit space: merged, cleaned, checked, recentred in float64."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gpu.errors import SceneError
from gpu.scene import validate
from gpu.scene.blending import blending_notes
from gpu.scene.boxes import box
from gpu.scene.bulk import bulk_of
from gpu.scene.default_light import with_default_light
from gpu.scene.default_view import default_camera
from gpu.scene.emitted_power import emitted_power
from gpu.scene.floats import triple
from gpu.scene.guess import Shape, frame_of, said_metres
from gpu.scene.import_options import DEFAULT_OPTIONS, Axis, ImportOptions
from gpu.scene.lengths import length_text
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.motion import Body, Motion
from gpu.scene.normals import area_vectors, repaired_normals
from gpu.scene.objects import numbered
from gpu.scene.precision import device_precision, file_precision
from gpu.scene.shut_in import is_shut_in
from gpu.scene.sky_dome import sky_notes, with_sky_dome
from gpu.scene.soundness import sound
from gpu.scene.to_world import camera_in_world, intensity_scale, light_in_unit_space
from gpu.scene.types import (
    Camera,
    Doubles,
    Floats,
    Integers,
    Light,
    LightKind,
    LoadReport,
    Mask,
    Material,
    Placement,
    Scene,
    Sky,
    Texture,
)

_MOST_UV = 1e30  # texture coordinates are of single precision on the device, which repeats a texture long before


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
    sky: Sky | None = None
    ignored: Sequence[str] = ()
    notes: Sequence[str] = ()
    up: Axis | None = None
    metres_per_unit: float | None = None
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)
    motion: Motion | None = None


def assemble(
    name: str, found: SceneParts, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS
) -> Scene:
    """Merge what was `found` into one scene, scaled so that its largest extent is 1 and centred on the origin.

    Its world is in metres with +Y up, as `options` and the file say or else as is guessed, counted from the origin that
    `options` give. What is small and too far away to be seen is left out.
    Degenerate triangles are dropped and counted; normals that are missing, zero or not finite become geometric ones. A
    sky of triangles becomes a backdrop. A scene that nothing lights gets a light, one without a camera a view; the
    report's notes say so.
    Raises SceneError when an array is not finite or refers to what is not there, a number is too large to compute with,
    nothing visible is left, or a limit is exceeded.
    """
    _check(name, found, limits)
    _check_choices(name, found.choices, options)
    metres = said_metres(found.metres_per_unit, options)
    meshes = [part for part in found.meshes if len(part.triangles)]
    parts = [_with_normals(part) for part in meshes]
    validate.check_count(name, "vertices", sum(len(p.positions) for p in parts), limits.max_vertices, "max_vertices")
    if not parts:
        raise SceneError(name, "", "; ".join(["no triangles; points and lines are not rendered", *found.ignored[:3]]))

    positions, triangles, material = _merged(parts)
    sun = any(light.kind is LightKind.DIRECTIONAL for light in found.lights)
    materials = with_sky_dome(positions, triangles, material, found.materials, sun=sun)
    backdrop = np.array([made.backdrop for made in materials])[material]
    bulk = bulk_of(positions, triangles, ~backdrop)
    shape = Shape(positions, triangles[bulk.member], bulk.low, bulk.high)
    frame, guesses = frame_of(shape, found.up, found.metres_per_unit, options)
    notes = [*found.notes, *guesses]
    world = frame.to_world(positions)
    too_far = bulk.too_far & ~backdrop & ~np.array([made.emits for made in materials])[material]
    notes += sky_notes(materials)
    notes += blending_notes(materials[number] for number in np.unique(material).tolist())
    notes += _far_away(too_far, bulk.distances * frame.metres_per_unit)
    notes += file_precision(positions, bulk, frame.metres_per_unit)

    kept, vertices, placement = _sound_parts(name, world, triangles, ~too_far, backdrop)
    dropped = int(np.count_nonzero(~too_far & ~kept))
    member = bulk.member if (bulk.member & kept).any() else kept
    low, high = box(world, triangles[member & kept])
    triangles, material, member = triangles[kept], material[kept], member[kept]

    used = np.zeros(len(world), bool)
    used[triangles] = True
    scale = intensity_scale(frame, placement, metres)
    motion = found.motion and replace(found.motion, bodies=_bodies(meshes, used), intensity_scale=scale)
    triangles = (np.cumsum(used) - 1)[triangles].astype(np.int32)
    vertices = np.ascontiguousarray(vertices[used])
    normals = frame.turned(np.concatenate([np.asarray(part.normals, np.float64) for part in parts])[used])
    objects, vertex_object = numbered((part.owners for part in parts), used)
    notes += device_precision(vertices, triangles, 1.0 / placement.scale)
    cameras = [camera_in_world(camera, frame) for camera in found.cameras]
    glass = np.array([one.is_clear for one in materials])[material[member]]
    if not cameras:
        cameras = [default_camera(vertices, triangles[member], placement, glass)]
        notes.append("the scene has no camera: a view was chosen")
    scene = Scene(
        name=name,
        vertices=vertices,
        normals=repaired_normals(normals, vertices, triangles),
        uvs=_merged_uvs(parts, materials)[:, used],
        colors=_merged_colors(parts, used),
        triangles=triangles,
        triangle_material=material.astype(np.int32),
        materials=tuple(materials),
        textures=tuple(found.textures),
        lights=tuple(light_in_unit_space(light, frame, placement, metres) for light in found.lights),
        sky=found.sky,
        cameras=tuple(cameras),
        placement=placement,
        report=LoadReport(tuple(found.ignored), dropped, tuple(notes)),
        bounds=(triple(low), triple(high)),
        frame=frame,
        choices=found.choices,
        objects=objects,
        vertex_object=vertex_object,
        motion=motion,
    )
    shines = any(max(light.intensity) > 0.0 for light in scene.lights)
    if shines or scene.sky is not None or emitted_power(scene).any():
        if found.cameras or not _stands_outside(cameras[0], low, high) or not is_shut_in(scene):
            return scene
        # Its fronts may face outwards, as those of a cube that became a room: there is nothing to see but from within.
        return replace(scene, cameras=(default_camera(vertices, triangles[member][:, ::-1], placement, glass),))
    if not scene.lights:
        return with_default_light(scene)
    said = "all its lights are switched off (their intensity is 0), so it is dark"
    return replace(scene, report=replace(scene.report, notes=(*scene.report.notes, said)))


def _stands_outside(camera: Camera, low: Doubles, high: Doubles) -> bool:
    """Whether `camera` is outside of the box from `low` to `high` (3,)."""
    eye = camera.to_world[:3, 3]
    return bool((eye < low).any() or (eye > high).any())


def _far_away(too_far: Mask, distances: Doubles) -> list[str]:
    """A sentence on the triangles (triangle,) that were left out, if any; distances: of all triangles [m]."""
    if not too_far.any():
        return []
    distance = length_text(float(distances[too_far].max()))
    return [f"triangles left out, as they are too small to be seen from {distance} away: {np.count_nonzero(too_far):,}"]


def _check(name: str, found: SceneParts, limits: SceneLimits) -> None:
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


def _check_choices(name: str, choices: Mapping[str, Sequence[str]], options: ImportOptions) -> None:
    """Raise SceneError for a variant or storey that the file does not have."""
    for kind, wanted in (("variant", [options.variant] if options.variant else []), ("storey", options.storeys)):
        offered = choices.get(kind, ())
        if wrong := [one for one in wanted if one not in offered]:
            there = f"it has {', '.join(offered)}" if offered else "it has none"
            raise SceneError(name, "", f"there is no {kind} {wrong[0]!r:.80} in it; {there}")


def _bodies(meshes: Sequence[MeshPart], used: Mask) -> tuple[Body, ...]:
    """The parts that move, with the vertices of theirs that are `used`, (vertex,) of all parts `_with_normals`."""
    bodies, start, first = list[Body](), 0, 0
    for part in meshes:
        own = np.arange(len(part.positions)) if part.normals is not None else part.triangles.reshape(-1)
        kept = own[used[start : start + len(own)]].astype(np.int32)
        if part.body is not None and len(kept):
            bodies.append(replace(part.body, first_vertex=first, vertices=kept))
        start, first = start + len(own), first + len(kept)
    return tuple(bodies)


def _with_normals(part: MeshPart) -> MeshPart:
    """`part`; one that has no normals with vertices of its own for each triangle, and that triangle's normal (glTF 2.0,
    3.7.2.1).
    """
    if part.normals is not None:
        return part
    corner = part.triangles.reshape(-1)
    positions = part.positions[corner]
    triangles = np.arange(len(corner), dtype=np.int32).reshape(-1, 3)
    normals = np.repeat(area_vectors(positions, triangles), 3, axis=0)
    uvs = tuple(uv[corner] for uv in part.uvs)
    colors = None if part.colors is None else part.colors[corner]
    own = None if part.vertex_object is None else part.vertex_object[corner]
    return replace(
        part, positions=positions, triangles=triangles, normals=normals, uvs=uvs, colors=colors, vertex_object=own
    )


def _merged(parts: Sequence[MeshPart]) -> tuple[Doubles, Integers, Integers]:
    """Positions (vertex, 3), triangles (triangle, 3) and their materials (triangle,) of all parts."""
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    triangles = np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=False)])
    material = np.repeat([part.material for part in parts], [len(part.triangles) for part in parts])
    return np.concatenate([np.asarray(part.positions, np.float64) for part in parts]), triangles, material


def _recentred(world: Doubles, triangles: Integers) -> tuple[Doubles, Placement]:
    """World positions (vertex, 3) in the unit space of the box around `triangles`, and that space."""
    low, high = box(world, triangles)
    centre, extent = low + (high - low) / 2.0, float((high - low).max())
    scale = 1.0 / extent if extent > 1.0 / validate.FARTHEST else 1.0
    return (world - centre) * scale, Placement((float(centre[0]), float(centre[1]), float(centre[2])), scale)


def _sound_parts(
    name: str, world: Doubles, triangles: Integers, seen: Mask, backdrop: Mask
) -> tuple[Mask, Floats, Placement]:
    """Which triangles are `seen` and have an area in single precision, and all vertices in the unit space around them.

    Raises SceneError when none but a `backdrop` is left.
    """
    kept = seen & sound(_recentred(world, triangles[seen & ~backdrop])[0], triangles)
    _check_some(name, kept & ~backdrop)
    unit, placement = _recentred(world, triangles[kept & ~backdrop])
    with np.errstate(over="ignore"):  # of what is left out
        vertices = unit.astype(np.float32)
    kept &= sound(vertices.astype(np.float64), triangles)
    _check_some(name, kept & ~backdrop)  # those that have one beside others that are too far away are lost as well
    return kept, vertices, placement


def _check_some(name: str, kept: Mask) -> None:
    """Raise SceneError when no triangle is left, of which `kept` (triangle,) says whether it is."""
    if not kept.any():
        raise SceneError(name, "", f"none of its {len(kept)} triangles has an area")


def _merged_uvs(parts: Sequence[MeshPart], materials: Sequence[Material]) -> Floats:
    """UV sets (set, vertex, 2) up to the last that a material uses, at least one; zero where a part has none."""
    sets = 1 + max((slot.uv_set for material in materials for slot in validate.slots(material).values()), default=0)
    merged = np.zeros((sets, sum(len(part.positions) for part in parts), 2), np.float32)
    start = 0
    for part in parts:
        for number, uv in enumerate(part.uvs[:sets]):
            merged[number, start : start + len(uv)] = np.clip(uv, -_MOST_UV, _MOST_UV)
        start += len(part.positions)
    return merged


def _merged_colors(parts: Sequence[MeshPart], used: Mask) -> Floats | None:
    """Vertex colours (used vertex, 4), white where a part has none, or None when no part has any."""
    if all(part.colors is None for part in parts):
        return None
    white = [np.ones((len(part.positions), 4)) if part.colors is None else part.colors for part in parts]
    return np.concatenate(white)[used].astype(np.float32)
