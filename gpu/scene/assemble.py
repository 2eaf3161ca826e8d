"""From mesh parts in a file's coordinates to a Scene in unit space: merged, cleaned, checked, recentred in float64."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gpu.errors import SceneError
from gpu.scene import validate
from gpu.scene.animation.motion import Body
from gpu.scene.computable import computable
from gpu.scene.default_view import default_camera
from gpu.scene.file_frame import FileFrame
from gpu.scene.floats import triple
from gpu.scene.geometry.boxes import box
from gpu.scene.geometry.bulk import Bulk, bulk_of
from gpu.scene.geometry.normals import area_vectors, repaired_normals
from gpu.scene.geometry.precision import device_precision, file_precision
from gpu.scene.geometry.soundness import sound
from gpu.scene.guess import Shape, frame_of, said_metres
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.lengths import length_text
from gpu.scene.lighting.covered_lights import covered_lights
from gpu.scene.lighting.default_light import with_default_light
from gpu.scene.lighting.emitted_power import emitted_power
from gpu.scene.lighting.shut_in import is_shut_in
from gpu.scene.lighting.sky_dome import sky_notes, with_sky_dome
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.objects import numbered
from gpu.scene.scene_parts import MeshPart, SceneParts, check_choices, check_parts
from gpu.scene.to_world import camera_in_world, intensity_scale, light_in_unit_space
from gpu.scene.types import (
    Camera,
    Doubles,
    Floats,
    Integers,
    LightKind,
    LoadReport,
    Mask,
    Material,
    Placement,
    Scene,
)

_MOST_UV = 1e30  # texture coordinates are of single precision on the device, which repeats a texture long before


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
    found = computable(found)
    check_parts(name, found, limits)
    check_choices(name, found.choices, options)
    meshes = [part for part in found.meshes if len(part.triangles)]
    parts = [_with_normals(part) for part in meshes]
    validate.check_count(name, "vertices", sum(len(p.positions) for p in parts), limits.max_vertices, "max_vertices")
    if not parts:
        raise SceneError(name, "", "; ".join(["no triangles; points and lines are not rendered", *found.ignored[:3]]))

    whole = _in_world(parts, found, options)
    kept, vertices, placement = _sound_parts(name, whole)
    member = whole.bulk.member if (whole.bulk.member & kept).any() else kept
    low, high = box(whole.positions, whole.triangles[member & kept])
    material, member = whole.material[kept], member[kept]
    used = np.zeros(len(vertices), bool)
    used[whole.triangles[kept]] = True
    triangles = (np.cumsum(used) - 1)[whole.triangles[kept]].astype(np.int32)
    vertices = np.ascontiguousarray(vertices[used])
    normals = whole.frame.turned(np.concatenate([np.asarray(part.normals, np.float64) for part in parts])[used])
    objects, vertex_object = numbered((part.owners for part in parts), used)
    metres, frame, materials = said_metres(found.metres_per_unit, options), whole.frame, whole.materials
    scale = intensity_scale(frame, placement, metres)
    notes = [*whole.notes, *device_precision(vertices, triangles, 1.0 / placement.scale)]
    glass = np.array([one.is_clear for one in materials])[material[member]]
    cameras = [camera_in_world(camera, frame) for camera in found.cameras]
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
        report=LoadReport(tuple(found.ignored), int(np.count_nonzero(~whole.too_far & ~kept)), tuple(notes)),
        bounds=(triple(low), triple(high)),
        frame=frame,
        choices=found.choices,
        objects=objects,
        vertex_object=vertex_object,
        motion=found.motion and replace(found.motion, bodies=_bodies(meshes, used), intensity_scale=scale),
    )
    if not _is_lit(scene):
        return _with_light(scene)
    if covered := covered_lights(scene):
        scene = replace(scene, report=replace(scene.report, notes=(*scene.report.notes, *covered)))
    if not found.cameras and _stands_outside(cameras[0], low, high) and is_shut_in(scene):
        # Its fronts may face outwards, as those of a cube that became a room: there is nothing to see but from within.
        inwards = default_camera(vertices, triangles[member][:, ::-1], placement, glass)
        return replace(scene, cameras=(inwards,))
    return scene


def _is_lit(scene: Scene) -> bool:
    """Whether something in `scene` emits light."""
    shines = any(max(light.intensity) > 0.0 for light in scene.lights)
    return shines or scene.sky is not None or bool(emitted_power(scene).any())


def _with_light(scene: Scene) -> Scene:
    """`scene`, which nothing lights, with a light; where its own are off, with a note."""
    if not scene.lights:
        return with_default_light(scene)
    said = "all its lights are switched off (their intensity is 0), so it is dark"
    return replace(scene, report=replace(scene.report, notes=(*scene.report.notes, said)))


@dataclass(frozen=True, eq=False)
class _Whole:
    """All parts together in the world.

    positions (vertex, 3) [m]; triangles (triangle, 3), indices of these; material (triangle,): index into materials;
    backdrop, too_far (triangle,): which are a sky around all others, and which are left out, too small to be seen from
    so far away; bulk: in the file's coordinates; notes: what is to be said of all that.
    """

    positions: Doubles
    triangles: Integers
    material: Integers
    materials: Sequence[Material]
    backdrop: Mask
    too_far: Mask
    bulk: Bulk
    frame: FileFrame
    notes: Sequence[str]


def _in_world(parts: Sequence[MeshPart], found: SceneParts, options: ImportOptions) -> _Whole:
    """Merge `parts`, those of `found`, in the world that `options` and the file say, or else as is guessed."""
    positions, triangles, material = _merged(parts)
    sun = any(light.kind is LightKind.DIRECTIONAL for light in found.lights)
    materials = with_sky_dome(positions, triangles, material, found.materials, sun=sun)
    backdrop = np.array([made.backdrop for made in materials])[material]
    bulk = bulk_of(positions, triangles, ~backdrop)
    shape = Shape(positions, triangles[bulk.member], bulk.low, bulk.high)
    frame, guesses = frame_of(shape, found.up, found.metres_per_unit, options)
    too_far = bulk.too_far & ~backdrop & ~np.array([made.emits for made in materials])[material]
    notes = [
        *found.notes,
        *guesses,
        *sky_notes(materials),
        *_far_away(too_far, bulk.distances * frame.metres_per_unit),
        *file_precision(positions, bulk, frame.metres_per_unit),
    ]
    world = frame.to_world(positions)
    return _Whole(world, triangles, material, materials, backdrop, too_far, bulk, frame, notes)


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


def _sound_parts(name: str, whole: _Whole) -> tuple[Mask, Floats, Placement]:
    """Which triangles are seen and have an area in single precision, and all vertices in the unit space around them.

    Raises SceneError when none but a backdrop is left.
    """
    world, triangles, seen, solid = whole.positions, whole.triangles, ~whole.too_far, ~whole.backdrop
    kept = seen & sound(_recentred(world, triangles[seen & solid])[0], triangles)
    _check_some(name, kept & solid)
    unit, placement = _recentred(world, triangles[kept & solid])
    with np.errstate(over="ignore"):  # of what is left out
        vertices = unit.astype(np.float32)
    kept &= sound(vertices.astype(np.float64), triangles)
    _check_some(name, kept & solid)  # those that have one beside others that are too far away are lost as well
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
