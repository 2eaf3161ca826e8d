"""The lights and materials of a scene by ids that people can read and that stay as long as its file does."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache

from gpu.errors import brief
from gpu.scene.lighting.added_daylight import SUN_COLOR, SUN_NAME, has_sun
from gpu.scene.lighting.default_light import SOFT_SKY
from gpu.scene.types import Environment, LightKind, Rgb, Scene

MOST_ID = 80  # characters of an id; names of files may be longer


class LightForm(StrEnum):
    """What a light is."""

    POINT = "point"
    SPOT = "spot"
    DIRECTIONAL = "directional"
    SURFACE = "surface"
    SKY = "sky"


@dataclass(frozen=True)
class LightPart:
    """A light of a scene. index: among the scene's lights, of a surface among its materials, of a sky 0; color: as the
    file says, linear Rec. 709, its largest channel 1; added: the file has none, and it shines if an edit adds it.
    """

    id: str
    form: LightForm
    index: int
    color: Rgb
    added: bool = False


FORMS = {LightKind.POINT: LightForm.POINT, LightKind.SPOT: LightForm.SPOT, LightKind.DIRECTIONAL: LightForm.DIRECTIONAL}


def lights_of(scene: Scene) -> tuple[LightPart, ...]:
    """All that lights `scene`: its punctual lights, then its emissive materials, then its sky; last a sun and a sky
    that may be added to it.
    """
    found = [(light.name, FORMS[light.kind], index, light.intensity) for index, light in enumerate(scene.lights)]
    for index, material in enumerate(scene.materials):
        if material.emits:
            found.append((material.name, LightForm.SURFACE, index, material.emission))
    if scene.sky is not None:
        color = (1.0, 1.0, 1.0) if isinstance(scene.sky, Environment) else scene.sky.radiance
        found.append(("sky", LightForm.SKY, 0, color))
    own = len(found)
    if not has_sun(scene):
        found.append((SUN_NAME, LightForm.DIRECTIONAL, len(scene.lights), SUN_COLOR))
    if scene.sky is None:
        found.append(("sky", LightForm.SKY, 0, SOFT_SKY.radiance))
    ids = unique_ids((name or form for name, form, _, _ in found), "light")
    return tuple(
        LightPart(one, form, index, _chroma(color), added=number >= own)
        for number, (one, (_, form, index, color)) in enumerate(zip(ids, found, strict=True))
    )


def material_ids(scene: Scene) -> tuple[str, ...]:
    """The ids of a scene's materials, in their order."""
    return unique_ids((material.name for material in scene.materials), "material")


def unique_ids(names: Iterable[str], kind: str) -> tuple[str, ...]:
    """An id for each name: the name itself, or what it is of (`kind`) without one; "name (2)" where it is taken."""
    return _unique_ids(tuple(names), kind)


@lru_cache(maxsize=16)  # asked again in each edit of a scene
def _unique_ids(names: tuple[str, ...], kind: str) -> tuple[str, ...]:
    taken: dict[str, None] = {}  # in order
    counts: Counter[str] = Counter()
    for name in names:
        base = brief(name, MOST_ID).strip() or kind
        one = base
        while one in taken:
            counts[base] += 1
            one = f"{base} ({counts[base] + 1})"
        taken[one] = None
    return tuple(taken)


def _chroma(color: Rgb) -> Rgb:
    most = max(color)
    return (color[0] / most, color[1] / most, color[2] / most) if most > 0.0 else (1.0, 1.0, 1.0)
