"""The image files that MTL maps name, as textures: sought beside the library, then beside the OBJ file."""

import posixpath
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

import numpy as np

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.formats.files import ends_in, file_beside, read_bytes
from gpu.scene.formats.images import decode_image, fitted
from gpu.scene.formats.mtl.statements import MapStatement, MtlMaterial
from gpu.scene.formats.text import uncommented
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.types import Bytes, Texture, TextureSlot, Wrap

_LOOKED_AT = 256  # pixels along a side


@dataclass(frozen=True, eq=False)
class MapImage:
    """A map whose file was read. pixels: (height, width, 4) uint8."""

    statement: MapStatement
    path: Path
    pixels: Bytes

    @property
    def transform(self) -> tuple[float, float, float, float, float, float]:
        """The 2×3 matrix from (u, v, 1), v counted from the top, to the texture's own."""
        (u, v), (left, up) = self.statement.scale, self.statement.offset
        return (u, 0.0, left, 0.0, v, 1.0 - v - up)


class MapFiles:
    """Files of one OBJ scene: each image read once, textures made of them by what they are for."""

    def __init__(self, scene: Path, limits: SceneLimits, remarks: Remarks) -> None:
        self.textures: list[Texture] = []
        self._scene, self._limits, self._remarks = scene, limits, remarks
        self._pixels: dict[Path, Bytes | None] = {}
        self._numbers: dict[tuple[object, ...], int] = {}

    def find(self, name: str, field: str, beside: Path | None = None) -> Path | None:
        """The file called `name` in the folder of the library `beside`, else in the scene's; None when there is none.

        Of an absolute path the end is looked for. Raises SceneError for a name that leaves the scene's folder.
        """
        absolute = PureWindowsPath(name).anchor != ""
        home = self._scene.parent.resolve()
        folders = dict.fromkeys([*([beside.parent.relative_to(home).as_posix()] if beside else []), ""])
        wanted = [
            posixpath.normpath(posixpath.join(folder, relative))
            for folder in folders
            for relative in (ends_in(home / folder, name) if absolute else [name.replace("\\", "/")])
        ]
        for place in wanted:
            if place == wanted[0] or not place.startswith(".."):
                path = file_beside(self._scene, place, field, self._remarks)
                if path is not None:
                    if absolute:
                        self._remarks.add(f"{name[-60:]!r} was read from {place!r} beside the scene", field)
                    return path
        return None

    def image(self, said: MtlMaterial, key: str, library: Path) -> MapImage | None:
        """The map that a material has as `key`; None, and said, when its file is missing or no image.

        Raises SceneError for a file outside the scene's folder, ForbiddenError for a limit.
        """
        statement = said.map(key)
        if statement is None:
            return None
        place = said.values[key][1]
        names = dict.fromkeys((statement.name, uncommented(statement.name).strip('"')))
        path = next((path for name in names if name and (path := self.find(name, place, library))), None)
        if path is None:
            self._remarks.add(f"texture {statement.name} is missing")
            return None
        if path not in self._pixels:
            self._pixels[path] = self._read(path, place)
        pixels = self._pixels[path]
        return None if pixels is None else MapImage(statement, path, pixels)

    def _read(self, path: Path, place: str) -> Bytes | None:
        try:
            return decode_image(read_bytes(path, self._limits), str(self._scene), path.name, self._limits)
        except ForbiddenError:
            raise
        except SceneError as error:
            self._remarks.add(f"texture {path.name} was ignored: {error.problem}", place)
            return None

    def color_slot(self, base: MapImage | None, mask: MapImage | None) -> TextureSlot:
        """A texture of colours, with `mask` as its alpha; laid as `base`, or as `mask` where there is no base."""
        laid = base or mask
        assert laid is not None
        if base and mask and mask.transform != base.transform:
            self._remarks.add("the options of map_d were ignored: it lies as map_Kd does")

        def pixels() -> Bytes:
            color = base.pixels if base else np.full_like(laid.pixels, 255)
            alpha = np.full_like(color[:, :, 3], 255) if mask is None else fitted(_opacity(mask), color)
            return np.dstack([color[:, :, :3], alpha])

        return self._slot(laid, True, (base and base.path, mask and mask.path, "color"), pixels)

    def rough_metal_slot(self, rough: MapImage | None, metal: MapImage | None) -> TextureSlot:
        """A texture with roughness in green and metalness in blue (glTF 2.0, 3.9.2), 1 where there is none."""
        laid = rough or metal
        assert laid is not None
        if rough and metal and rough.transform != metal.transform:
            self._remarks.add("the options of map_Pm were ignored: it lies as map_Pr does")

        def pixels() -> Bytes:
            made = np.full_like(laid.pixels, 255)
            for channel, image in ((1, rough), (2, metal)):
                if image:
                    made[:, :, channel] = fitted(image.pixels[:, :, 0], made)
            return made

        return self._slot(laid, False, (rough and rough.path, metal and metal.path, "rough metal"), pixels)

    def data_slot(self, image: MapImage) -> TextureSlot:
        """A texture whose numbers are no colours."""
        return self._slot(image, False, (image.path, "data"), lambda: image.pixels)

    def _slot(
        self, laid: MapImage, srgb: bool, made_of: tuple[object, ...], pixels: Callable[[], Bytes]
    ) -> TextureSlot:
        """The use of a texture, laid as the options of `laid` say; made once for each way to make it."""
        key = (*made_of, laid.statement.clamp)
        if key not in self._numbers:
            wrap = Wrap.CLAMP if laid.statement.clamp else Wrap.REPEAT
            self.textures.append(Texture(laid.path.name, pixels(), srgb, wrap, wrap))
            self._numbers[key] = len(self.textures) - 1
        return TextureSlot(self._numbers[key], transform=laid.transform)


def is_normal_map(pixels: Bytes) -> bool:
    """Whether colours (height, width, 4) are directions, nearly all of unit length and mostly outwards, as of a
    tangent-space normal map (glTF 2.0, 3.9.3); heights, which are grey, are none.
    """
    step = max(max(pixels.shape[:2]) // _LOOKED_AT, 1)
    directions = pixels[::step, ::step, :3].reshape(-1, 3) / 127.5 - 1.0
    lengths = np.linalg.norm(directions, axis=1)
    return bool(np.mean(np.abs(lengths - 1.0) < 0.2) > 0.9 and directions[:, 2].mean() > 0.5)


def _opacity(mask: MapImage) -> Bytes:
    """The opacity (height, width) of a map_d: its alpha where it has any, else its brightness."""
    alpha = mask.pixels[:, :, 3]
    return alpha if (alpha < 255).any() else mask.pixels[:, :, :3].max(axis=2)
