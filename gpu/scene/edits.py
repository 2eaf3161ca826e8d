"""Edits of a scene that is open: lights off, brighter, elsewhere or of another colour, materials of another finish.

What a scene's file says stays as it is; edits are said as what differs from it, all of them together, so the same edits
of the same scene always are the same scene, whatever came before.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator

from gpu.errors import UserError
from gpu.scene.parts import MOST_ID, LightForm, lights_of, material_ids
from gpu.scene.to_world import as_vector
from gpu.scene.types import Environment, Light, Material, Placement, Rgb, Scene, Sky

MOST_SHOWN = 5  # ids in a sentence on one that there is not
PLACED = (LightForm.POINT, LightForm.SPOT)
AIMED = (LightForm.SPOT, LightForm.DIRECTIONAL)
_BLACK = Sky((0.0, 0.0, 0.0))

Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Color = Annotated[tuple[Share, Share, Share], Field(description="linear Rec. 709, each channel from 0 to 1")]
Radiance = Annotated[FiniteFloat, Field(ge=0.0, le=1e6)]
Metres = Annotated[FiniteFloat, Field(ge=-1e9, le=1e9)]
PartId = Annotated[str, Field(min_length=1, max_length=MOST_ID + 16)]


class _Edit(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class LightEdit(_Edit):
    """What differs of a light; None is as the file says."""

    on: bool | None = Field(default=None, description="whether it shines")
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

    @field_validator("direction")
    @classmethod
    def _goes_somewhere(cls, direction: Rgb | None) -> Rgb | None:
        if direction is not None and not 1e-6 < float(np.linalg.norm(direction)) < 1e6:
            raise ValueError("must have a length from 1e-6 to 1e6")
        return direction

    def scale(self, color: Rgb) -> Rgb:
        """A light's `color`, of any unit, with this edit: its largest channel changes by `factor` alone."""
        if self.color is not None:
            most = max(color)
            color = (most * self.color[0], most * self.color[1], most * self.color[2])
        factor = self.factor
        return (factor * color[0], factor * color[1], factor * color[2])

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


class SceneEdits(_Edit):
    """All that differs from a scene's file, by the ids that gpu.scene.parts gives. Materials come before lights: an
    emissive surface shines as its material's emission says, times what its light's edit says.
    """

    lights: dict[PartId, LightEdit] = Field(default={}, description="by the light's id")
    materials: dict[PartId, MaterialEdit] = Field(default={}, description="by the material's id")

    def __hash__(self) -> int:
        return hash(self.model_dump_json())


NO_EDITS = SceneEdits()


def edited(scene: Scene, edits: SceneEdits) -> Scene:
    """`scene` with other lights and materials, and the same geometry; UserError for an id that it has not."""
    materials = dict(zip(material_ids(scene), scene.materials, strict=True))
    lights = {part.id: part for part in lights_of(scene)}
    check(edits, {part.id: part.form for part in lights.values()}, materials)
    for one, change in edits.materials.items():
        materials[one] = _edited_material(materials[one], change)
    made, punctual, sky = list(materials.values()), list(scene.lights), scene.sky
    for one, edit in edits.lights.items():
        index = lights[one].index
        match lights[one].form:
            case LightForm.SURFACE:
                made[index] = replace(made[index], emission=edit.scale(made[index].emission))
            case LightForm.SKY if sky is not None:
                sky = _edited_sky(sky, edit)
            case _:
                punctual[index] = _edited_light(punctual[index], edit, scene.placement)
    return replace(scene, materials=tuple(made), lights=tuple(punctual), sky=sky)


def check(edits: SceneEdits, lights: Mapping[str, LightForm], materials: Collection[str]) -> None:
    """Raise UserError, which names the field, where `edits` are of a light or a material that is not among these, or
    turn or move a light that cannot be.
    """
    for field, edit, there in (("lights", edits.lights, lights), ("materials", edits.materials, materials)):
        unknown = next((one for one in edit if one not in there), None)
        if unknown is not None:
            known = ", ".join(list(there)[:MOST_SHOWN]) or "none"
            more = f" and {len(there) - MOST_SHOWN} more" if len(there) > MOST_SHOWN else ""
            raise UserError(f"{field}.{unknown}: the scene has no such {field[:-1]}; it has {known}{more}")
    for one, light in edits.lights.items():
        for field, moved, movable in (("position", light.position, PLACED), ("direction", light.direction, AIMED)):
            if moved is not None and lights[one] not in movable:
                raise UserError(f"lights.{one}.{field}: a light of this kind ({lights[one]}) has none")


def _edited_material(material: Material, edit: MaterialEdit) -> Material:
    return replace(
        material,
        base_color=material.base_color if edit.color is None else (*edit.color, material.base_color[3]),
        roughness=material.roughness if edit.roughness is None else edit.roughness,
        metallic=material.metallic if edit.metallic is None else edit.metallic,
        emission=material.emission if edit.emission is None else edit.emission,
    )


def _edited_light(light: Light, edit: LightEdit, placement: Placement) -> Light:
    position, direction = light.position, light.direction
    if edit.position is not None:
        position = as_vector((np.array(edit.position) - placement.centre) * placement.scale)
    if edit.direction is not None:
        direction = as_vector(np.array(edit.direction) / np.linalg.norm(edit.direction))
    return replace(light, intensity=edit.scale(light.intensity), position=position, direction=direction)


def _edited_sky(sky: Sky | Environment, edit: LightEdit) -> Sky | Environment:
    if isinstance(sky, Sky):
        return Sky(edit.scale(sky.radiance))
    tint = np.array(edit.color or (1.0, 1.0, 1.0), np.float32) * np.float32(edit.factor)
    return replace(sky, pixels=sky.pixels * tint) if tint.any() else _BLACK
