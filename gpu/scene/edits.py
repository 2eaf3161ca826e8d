"""Edits of a scene that is open: another time; lights off, brighter, elsewhere or of another colour; materials of
another finish.

What a scene's file says stays as it is; edits are said as what differs from it, all of them together, so the same edits
of the same scene always are the same scene, whatever came before.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from math import hypot
from operator import is_
from typing import Annotated

import numpy as np
from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, FiniteFloat, field_validator

from gpu.errors import UserError
from gpu.scene.animation.moment import Moment
from gpu.scene.animation.posed import posed
from gpu.scene.floats import triple
from gpu.scene.lighting.added_daylight import with_daylight
from gpu.scene.lighting.daylight import daylight, level_radiance
from gpu.scene.lighting.path_light import path_light, with_path_light
from gpu.scene.lighting.sun import sun_direction, sun_position, sun_strength
from gpu.scene.objects import Move, with_objects
from gpu.scene.parts import MOST_ID, LightForm, lights_of, material_ids
from gpu.scene.pauses import Pause, go_on
from gpu.scene.types import Environment, Light, Material, Placement, Rgb, Scene, Sky

MOST_SHOWN = 5  # ids in a sentence on one that there is not
PLACED = (LightForm.POINT, LightForm.SPOT)
AIMED = (LightForm.SPOT, LightForm.DIRECTIONAL)
DATED = (LightForm.DIRECTIONAL, LightForm.SKY)
Box = tuple[Sequence[float], Sequence[float]]
_BOX_TOLERANCE = 1e-4  # of the scene's largest extent, by which what is moved may leave its box

Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Color = Annotated[tuple[Share, Share, Share], Field(description="linear Rec. 709, each channel from 0 to 1")]
Radiance = Annotated[FiniteFloat, Field(ge=0.0, le=1e6)]
Metres = Annotated[FiniteFloat, Field(ge=-1e9, le=1e9)]
Latitude = Annotated[FiniteFloat, Field(ge=-90.0, le=90.0)]
Longitude = Annotated[FiniteFloat, Field(ge=-180.0, le=180.0)]
Degrees = Annotated[FiniteFloat, Field(ge=-360.0, le=360.0)]
# Years for which the sun's position is known; dates of others need not even be ones in another zone.
FIRST_YEAR, LAST_YEAR = 1900, 2100
PartId = Annotated[str, Field(min_length=1, max_length=MOST_ID + 16)]


class _Edit(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class LightEdit(_Edit):
    """What differs of a light; None is as the file says."""

    on: bool | None = Field(
        default=None,
        description="whether it shines; a sun or a sky that the file has not does if this is true or it has a date",
    )
    intensity: FiniteFloat | None = Field(
        default=None, ge=0.0, le=1e4, description="how many times as bright as its file says"
    )
    color: Color | None = Field(default=None, description="of its light; of a sky that is a picture, what tints it")
    position: tuple[Metres, Metres, Metres] | None = Field(
        default=None, description="of a point or spot light, in the world, whose +Y is up [m]"
    )
    direction: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        default=None, description="where the light of a spot or a directional light goes, in the world, of any length"
    )

    date: AwareDatetime | None = Field(
        default=None,
        description="of 1900 to 2100; a directional light is the sun at this time, with its zone: it shines from "
        "there, unless a direction is given, and as much of it as comes through the air of what does when it is "
        "overhead; a sky is that of a clear day then, as bright as the file's when the sun is overhead",
    )
    place: tuple[Latitude, Longitude] | None = Field(
        default=None, description="of that sun: latitude and longitude, north and east are positive [°]"
    )
    north: Degrees | None = Field(
        default=None, description="for that sun: from −Z to the north, clockwise as seen from above [°]"
    )

    @field_validator("direction")
    @classmethod
    def _goes_somewhere(cls, direction: Rgb | None) -> Rgb | None:
        if direction is not None and not 1e-6 < hypot(*direction) < 1e6:
            raise ValueError("must have a length from 1e-6 to 1e6")
        return direction

    @field_validator("date")
    @classmethod
    def _has_a_sun(cls, date: datetime | None) -> datetime | None:
        if date is not None and not FIRST_YEAR <= date.year <= LAST_YEAR:
            raise ValueError(f"must be of a year from {FIRST_YEAR} to {LAST_YEAR}")
        return date

    @property
    def sun(self) -> tuple[float, float] | None:
        """Azimuth, clockwise from north, and height above the horizon [°] of the sun that it is, if it is one."""
        return None if self.date is None or self.place is None else sun_position(*self.place, self.date)

    @property
    def shines(self) -> Rgb | None:
        """The direction that it has by this edit."""
        if self.direction is not None or (sun := self.sun) is None:
            return self.direction
        return sun_direction(*sun, self.north or 0.0)

    def scale(self, color: Rgb) -> Rgb:
        """A light's `color`, of any unit, with this edit: its largest channel changes by `factor` alone."""
        if self.color is not None:
            most = max(color)
            color = (most * self.color[0], most * self.color[1], most * self.color[2])
        factor = self.factor
        return (factor * color[0], factor * color[1], factor * color[2])

    @property
    def adds(self) -> bool:
        """Whether a light that the file has not shines."""
        return self.date is not None if self.on is None else self.on

    @property
    def factor(self) -> float:
        """How many times as bright it is."""
        return 0.0 if self.on is False else 1.0 if self.intensity is None else self.intensity


class MaterialEdit(_Edit):
    """What differs of a material; None is as the file says. As in glTF, factors on what its textures say."""

    color: Color | None = Field(default=None, description="base colour")
    roughness: Share | None = None
    metallic: Share | None = None
    emission: tuple[Radiance, Radiance, Radiance] | None = Field(
        default=None, description="radiance [W/m²/sr], linear Rec. 709"
    )


class ObjectEdit(_Edit):
    """What differs of an object; None is as the file says."""

    visible: bool | None = Field(default=None, description="whether it is there")
    offset: tuple[Metres, Metres, Metres] | None = Field(
        default=None, description="by which it is moved, in the world, within the box of the scene [m]"
    )
    rotation: tuple[Degrees, Degrees, Degrees] | None = Field(
        default=None,
        description="by which it is turned about the world's X, Y and Z through its box's middle [°], Z first",
    )
    scale: FiniteFloat | None = Field(
        default=None,
        ge=0.1,
        le=10.0,
        description="how many times as large it is, about its box's middle, within the box of the scene",
    )

    @property
    def move(self) -> Move:
        """What it does with where the object is."""
        return Move(self.rotation or (0.0, 0.0, 0.0), self.offset or (0.0, 0.0, 0.0), self.scale or 1.0)


class SceneEdits(Moment):
    """All that differs from a scene's file, by the ids that gpu.scene.parts and gpu.scene.objects give.

    What moves with time comes first: an edit of a light or an object is of what is there then. Materials come before
    lights: an emissive surface shines as its material's emission says, times what its light's edit says.
    """

    lights: dict[PartId, LightEdit] = Field(default={}, description="by the light's id")
    materials: dict[PartId, MaterialEdit] = Field(default={}, description="by the material's id")
    objects: dict[PartId, ObjectEdit] = Field(default={}, description="by the object's id")

    def __hash__(self) -> int:
        # Of ids alone, which takes a tenth of a millisecond for a thousand: few states of a scene are kept at a time.
        parts = frozenset(self.lights), frozenset(self.materials), frozenset(self.objects)
        return hash((self.time, self.animation, *parts))


NO_EDITS = SceneEdits()


@dataclass(frozen=True)
class Editable:
    """What of a scene can be edited: the forms of its lights, its materials, the boxes of its objects, all by id, and
    the scene's own `bounds`, in world space; the ids of its animations.
    """

    lights: Mapping[str, LightForm]
    materials: Collection[str]
    objects: Mapping[str, Box]
    bounds: Box
    animations: Sequence[str] = ()


def edited(scene: Scene, edits: SceneEdits) -> Scene:
    """`scene` at another time, with other lights, materials and objects; arrays of geometry that are as before are the
    same ones.

    Raises UserError, which names the field, for what it has not or cannot be.
    """
    return shown(shaped(scene, edits), edits)


def shaped(scene: Scene, edits: SceneEdits, pause: Pause = go_on) -> Scene:
    """`scene` with what `edits` make of its geometry, and of what moves with time; the same for the same `shape_of`.

    pause: called between steps that take long. Raises UserError, which names the field, for what it has not or cannot
    be.
    """
    boxes = zip(*(corners.tolist() for corners in scene.object_boxes), strict=True) if edits.objects else ()
    objects = {one: (low, high) for one, (low, high) in zip(scene.objects, boxes, strict=False)}
    animations = {} if scene.motion is None else {one.id: one for one in scene.motion.animations}
    _check_shape(edits, objects, scene.bounds, [*animations])
    if edits.time is not None and scene.motion is not None:
        chosen = animations[edits.animation] if edits.animation else scene.motion.animations[0]
        scene = posed(scene, scene.motion, chosen, edits.time, pause)
    return _edited_objects(scene, edits.objects, pause)


def shape_of(edits: SceneEdits) -> object:
    """What `shaped` depends on."""
    return edits.time, edits.animation, edits.objects


def with_triangles_of(known: Scene, scene: Scene) -> Scene:
    """`scene` with the arrays of triangles of another state of it where these hold the same, as where the same objects
    are hidden, so that they are known to be the same.
    """
    if scene.triangles is known.triangles:
        return scene
    same = np.array_equal(scene.triangles, known.triangles)
    if not (same and np.array_equal(scene.triangle_material, known.triangle_material)):
        return scene
    return replace(scene, triangles=known.triangles, triangle_material=known.triangle_material)


def shown(scene: Scene, edits: SceneEdits) -> Scene:
    """A scene that is `shaped` by `edits`, with its materials and lights as they say.

    Raises UserError, which names the field, for what it has not or cannot be.
    """
    if not (edits.materials or edits.lights):
        return scene
    materials = dict(zip(material_ids(scene), scene.materials, strict=True))
    lights = {part.id: part for part in lights_of(scene)}
    _check_look(edits, {one: part.form for one, part in lights.items()}, materials)
    for one, change in edits.materials.items():
        materials[one] = _edited_material(materials[one], change)
    dark = {one for one, edit in edits.lights.items() if lights[one].added and not edit.adds}
    added = {lights[one].form for one in edits.lights.keys() - dark if lights[one].added}
    scene = with_daylight(scene, sun=LightForm.DIRECTIONAL in added, sky=LightForm.SKY in added)
    made, punctual, sky, filed = list(materials.values()), list(scene.lights), scene.sky, scene
    for one, edit in edits.lights.items():
        if one in dark:
            continue
        index = lights[one].index
        match lights[one].form:
            case LightForm.SURFACE:
                made[index] = replace(made[index], emission=edit.scale(made[index].emission), stays_light=True)
            case LightForm.SKY if sky is not None:
                filed = replace(scene, sky=_sky_of_date(sky, edit))
                sky = _edited_sky(_sky_of_date(sky, edit), edit)
            case _:
                punctual[index] = _edited_light(punctual[index], edit, scene.placement)
    same = all(map(is_, made, scene.materials))
    surfaces = scene.materials if same else tuple(made)  # known to be the same by being the same tuple
    lit = scene.relit(surfaces, tuple(punctual), sky)
    return with_path_light(lit, path_light(filed))


def check(edits: SceneEdits, there: Editable) -> None:
    """Raise UserError, which names the field, for what is not `there` or cannot be: a light of a kind that has no place
    or direction, an object that would leave the scene's box, or nothing that is visible.
    """
    _check_look(edits, there.lights, there.materials)
    _check_shape(edits, there.objects, there.bounds, there.animations)


def _check_look(edits: SceneEdits, lights: Mapping[str, LightForm], materials: Collection[str]) -> None:
    _check_ids("lights", edits.lights, lights)
    _check_ids("materials", edits.materials, materials)
    for one, light in edits.lights.items():
        for field, moved, movable in (("position", light.position, PLACED), ("direction", light.direction, AIMED)):
            if moved is not None and lights[one] not in movable:
                raise UserError(f"lights.{one}.{field}: a light of this kind ({lights[one]}) has none")
        if light.date is not None and lights[one] not in DATED:
            raise UserError(
                f"lights.{one}.date: only a directional light, as the sun, and a sky have one, not {lights[one]}"
            )
        if light.date is not None and light.place is None:
            raise UserError(f"lights.{one}.place: must be given for the sun of a date")


def _check_shape(edits: SceneEdits, objects: Mapping[str, Box], bounds: Box, animations: Sequence[str]) -> None:
    if edits.animation is not None and edits.animation not in animations:
        known = ", ".join(animations[:MOST_SHOWN]) or "none"
        raise UserError(f"animation: the scene has no {edits.animation!r:.80}; it has {known}")
    if edits.time is not None and not animations:
        raise UserError("time: the scene has no animations")
    _check_ids("objects", edits.objects, objects)
    low, high = bounds
    most = _BOX_TOLERANCE * max(b - a for a, b in zip(low, high, strict=True))
    for one, change in edits.objects.items():
        if change.offset is None and change.scale is None:
            continue
        move = change.move
        sides = zip(low, high, *objects[one], move.offset, strict=True)
        # Half of what its box grows by goes to each side.
        grown = [(a, b, c + by, d + by, 0.5 * (move.scale - 1.0) * (d - c)) for a, b, c, d, by in sides]
        beyond = max(max(a - c, d - b) + by for a, b, c, d, by in grown)
        if beyond > most:
            field = "scale" if change.offset is None else "offset"
            raise UserError(f"objects.{one}.{field}: takes it {beyond:.3g} m beyond the box of the scene")
    if edits.objects and sum(change.visible is False for change in edits.objects.values()) == len(objects):
        raise UserError("objects: one at least must stay visible")


def _check_ids(field: str, edits: Collection[str], there: Collection[str]) -> None:
    unknown = next((one for one in edits if one not in there), None)
    if unknown is not None:
        known = ", ".join(list(there)[:MOST_SHOWN]) or "none"
        more = f" and {len(there) - MOST_SHOWN} more" if len(there) > MOST_SHOWN else ""
        raise UserError(f"{field}.{unknown}: the scene has no such {field[:-1]}; it has {known}{more}")


def _edited_objects(scene: Scene, edits: Mapping[str, ObjectEdit], pause: Pause) -> Scene:
    numbers = {one: number for number, one in enumerate(scene.objects)}
    hidden = [numbers[one] for one, edit in edits.items() if edit.visible is False]
    moves = {numbers[one]: move for one, edit in edits.items() if (move := edit.move) != Move()}
    return with_objects(scene, hidden, moves, pause) if hidden or moves else scene


def _edited_material(material: Material, edit: MaterialEdit) -> Material:
    return replace(
        material,
        base_color=material.base_color if edit.color is None else (*edit.color, material.base_color[3]),
        roughness=material.roughness if edit.roughness is None else edit.roughness,
        metallic=material.metallic if edit.metallic is None else edit.metallic,
        emission=material.emission if edit.emission is None else edit.emission,
        stays_light=material.emits,
    )


def _edited_light(light: Light, edit: LightEdit, placement: Placement) -> Light:
    position, direction = light.position, light.direction
    if edit.position is not None:
        position = triple((np.array(edit.position) - placement.centre) * placement.scale)
    if (shines := edit.shines) is not None:
        direction = triple(np.array(shines) / np.linalg.norm(shines))
    intensity = edit.scale(light.intensity)
    if (sun := edit.sun) is not None:
        intensity = triple(np.array(intensity) * sun_strength(sun[1]))
    return replace(light, intensity=intensity, position=position, direction=direction)


def _sky_of_date(sky: Sky | Environment, edit: LightEdit) -> Sky | Environment:
    """The sky of a clear day by the date of `edit`, as bright as `sky` with the sun overhead; `sky` without a date."""
    if (sun := edit.sun) is None:
        return sky
    level = level_radiance(sky)
    azimuth, height = sun
    return Environment("daylight", daylight(height, azimuth + (edit.north or 0.0)), tint=(level, level, level))


def _edited_sky(sky: Sky | Environment, edit: LightEdit) -> Sky | Environment:
    if isinstance(sky, Sky):
        return Sky(edit.scale(sky.radiance))
    return replace(sky, tint=edit.scale(sky.tint))
