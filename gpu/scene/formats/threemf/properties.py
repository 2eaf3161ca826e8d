"""Properties of 3MF triangles as materials: base materials, colours, textures, and mixes of them."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.colors import srgb_to_linear
from gpu.scene.formats.images import decode_image
from gpu.scene.formats.mesh_colors import bare_material
from gpu.scene.formats.mtl import DEFAULT_MATERIAL
from gpu.scene.formats.threemf.model import Key, Model
from gpu.scene.formats.xml_tree import attribute_rows, number_row
from gpu.scene.types import AlphaMode, Doubles, Integers, Material, Texture, TextureSlot, Wrap

_WRAPS = {"wrap": Wrap.REPEAT, "mirror": Wrap.MIRROR, "clamp": Wrap.CLAMP, "none": Wrap.CLAMP}
_MOST_SHARE = 1e6  # programs write percent, too
_WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Surface:
    """Some of the triangles asked for: their numbers, their material, and what their corners (3 × triangle,) have."""

    triangles: Integers
    material: int
    uvs: Doubles | None = None
    colors: Doubles | None = None


@dataclass
class Properties:
    """The materials that triangles use, each made when first used."""

    model: Model
    materials: list[Material] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[object, int] = field(default_factory=dict)
    _textures: dict[Key, int | None] = field(default_factory=dict)

    def surfaces(self, key: Key | None, indices: Integers) -> Iterator[Surface]:
        """What triangles with `indices` (triangle, 3) in the group `key` look like; grey without a group."""
        group = None if key is None else self.model.resource(key)
        if key is None or group is None:
            yield Surface(np.arange(len(indices)), self._number(None, DEFAULT_MATERIAL))
            return
        count = len(group)
        sound = ((indices >= 0) & (indices < count)).all(axis=1)
        if not sound.all():
            self.model.remarks.add("properties that do not exist: the triangles are grey", f"group {key[1]}")
            yield Surface(np.flatnonzero(~sound), self._number(None, DEFAULT_MATERIAL))
        if sound.any():
            some = np.flatnonzero(sound)
            for surface in self._of_group(key, group, indices[some]):
                yield replace(surface, triangles=some[surface.triangles])

    def _of_group(self, key: Key, group: Element, indices: Integers) -> Iterator[Surface]:
        every = np.arange(len(indices))
        if group.tag == "basematerials":
            for base in np.unique(indices[:, 0]):
                material = self._base(group[base], f"group {key[1]}")
                yield Surface(np.flatnonzero(indices[:, 0] == base), self._number((key, int(base)), material))
        elif group.tag in ("colorgroup", "compositematerials"):
            colors = self._colors(key, group)
            yield Surface(every, self._number(key, bare_material(colors)), colors=colors[indices.reshape(-1)])
        elif group.tag == "texture2dgroup":
            slot = self._slot((key[0], group.get("texid", "")))
            material = replace(DEFAULT_MATERIAL, base_color=_WHITE if slot else (0.8, 0.8, 0.8, 1.0))
            uvs = self._coordinates(key, group)[indices.reshape(-1)]
            yield Surface(every, self._number(key, replace(material, base_color_slot=slot)), uvs=uvs)
        elif group.tag == "multiproperties":
            self.model.remarks.add("of properties in layers the first is shown", f"group {key[1]}")
            yield from self._first_layer(key, group, indices)
        else:
            self.model.remarks.add(f"properties of kind {group.tag} are not shown", f"group {key[1]}")
            yield Surface(every, self._number(None, DEFAULT_MATERIAL))

    def _number(self, key: object, material: Material) -> int:
        if key not in self._numbers:
            self.materials.append(material)
            self._numbers[key] = len(self.materials) - 1
        return self._numbers[key]

    def _base(self, base: Element, place: str) -> Material:
        """A base material; its colour is as on a display."""
        red, green, blue, alpha = (float(value) for value in self._color(base.get("displaycolor", ""), place))
        return replace(
            DEFAULT_MATERIAL,
            name=base.get("name", "base"),
            base_color=(red, green, blue, alpha),
            alpha_mode=AlphaMode.BLEND if alpha < 1.0 else AlphaMode.OPAQUE,
        )

    def _color(self, text: str, place: str) -> Doubles:
        """#RRGGBB or #RRGGBBAA as linear RGBA (4,); grey, and said, where it is none."""
        try:
            levels = np.frombuffer(bytes.fromhex(text.strip().removeprefix("#")), np.uint8)
        except ValueError:
            levels = np.empty(0, np.uint8)
        if len(levels) not in (3, 4):
            self.model.remarks.add("a colour that is not #RRGGBB or #RRGGBBAA was taken as grey", place)
            return np.array(DEFAULT_MATERIAL.base_color)
        return np.append(srgb_to_linear(levels[:3]), levels[3] / 255.0 if len(levels) == 4 else 1.0)

    def _colors(self, key: Key, group: Element) -> Doubles:
        """The linear colours (entry, 4) of a group of colours, or of mixes of base materials."""
        place = f"group {key[1]}"
        if group.tag == "colorgroup":
            return np.stack([self._color(entry.get("color", ""), place) for entry in group])
        base = self.model.resource((key[0], group.get("matid", "")))
        try:
            wanted = [int(word) for word in group.get("matindices", "").split()]
            bases = np.stack([self._base_color(base, number, place) for number in wanted])
            shares = np.stack([number_row(entry.get("values", "")) for entry in group])
            if not ((shares >= 0.0) & (shares <= _MOST_SHARE)).all():
                raise ValueError("shares are numbers of 0 to 1")
            return np.clip(shares @ bases / np.maximum(shares.sum(axis=1), 1e-9)[:, None], 0.0, 1.0)
        except (ValueError, IndexError) as error:
            raise SceneError(str(self.model.path), place, f"its mixes cannot be read: {error}") from error

    def _base_color(self, bases: Element | None, number: int, place: str) -> Doubles:
        if bases is None or not 0 <= number < len(bases):
            raise ValueError(f"there is no base material {number}")
        return self._color(bases[number].get("displaycolor", ""), place)

    def _coordinates(self, key: Key, group: Element) -> Doubles:
        """The coordinates (entry, 2) of a texture group; v = 0 is the bottom of a 3MF texture, not the top."""
        try:
            return attribute_rows(iter(group), ("u", "v")) * (1.0, -1.0) + (0.0, 1.0)
        except (KeyError, ValueError) as error:
            raise SceneError(str(self.model.path), f"group {key[1]}", f"its coordinates: {error}") from error

    def _first_layer(self, key: Key, group: Element, indices: Integers) -> Iterator[Surface]:
        first = (group.get("pids", "").split() or [""])[0]
        if first == key[1] or (layer := self.model.resource((key[0], first))) is None or layer.tag == group.tag:
            yield Surface(np.arange(len(indices)), self._number(None, DEFAULT_MATERIAL))
            return
        words = [(entry.get("pindices", "").split() or ["0"])[0] for entry in group]
        own = np.array([int(word) if word.isdecimal() else -1 for word in words], np.int64)
        yield from self.surfaces((key[0], first), own[indices])

    def _slot(self, key: Key) -> TextureSlot | None:
        """The texture called `key`; None, and said, where its image cannot be read."""
        if key not in self._textures:
            self._textures[key] = self._texture(key)
        number = self._textures[key]
        return None if number is None else TextureSlot(number)

    def _texture(self, key: Key) -> int | None:
        model, found = self.model, self.model.resource(key)
        if found is None:
            return None
        name = found.get("path", "")
        file = model.package.find(name)
        if file is None:
            model.remarks.add("a texture is missing in the package", name[-60:])
            return None
        try:
            pixels = decode_image(model.package.read(file), str(model.path), file, model.limits)
        except ForbiddenError:
            raise
        except SceneError as error:
            model.remarks.add(f"the texture was left out: {error.problem}", name[-60:])
            return None
        wraps = [_WRAPS.get(found.get(f"tilestyle{axis}", "wrap"), Wrap.REPEAT) for axis in "uv"]
        self.textures.append(Texture(file, pixels, True, wraps[0], wraps[1]))
        return len(self.textures) - 1
