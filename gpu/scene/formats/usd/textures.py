"""UsdUVTexture shaders as textures: files decoded once, channels of several put together where a material needs it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import Gf, Sdf, UsdShade

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.colors import srgb_to_linear
from gpu.scene.formats.images import decode_image
from gpu.scene.formats.usd.stage import Stage
from gpu.scene.transforms import slot_transform
from gpu.scene.types import Bytes, Doubles, Texture, TextureSlot, Wrap
from gpu.scene.validate import check_count

_WRAPS = {"repeat": Wrap.REPEAT, "useMetadata": Wrap.REPEAT, "clamp": Wrap.CLAMP, "mirror": Wrap.MIRROR}


@dataclass(frozen=True, eq=False)
class UvTexture:
    """A UsdUVTexture. file: what it shows; pixels (height, width, 4); scale, bias (4,): value = scale · pixel + bias.

    encoded: whether its colours are encoded as sRGB, None where the file does not say; transform: 3×3, of (u, v, 1).
    """

    file: str
    pixels: Bytes
    scale: Doubles
    bias: Doubles
    encoded: bool | None
    wraps: tuple[Wrap, Wrap]
    uv_name: str
    transform: Doubles

    def channel(self, number: int) -> Doubles:
        """The values (height, width) of one channel, linear."""
        raw = self.pixels[..., number]
        linear = srgb_to_linear(raw) if self.encoded and number < 3 else raw / 255.0
        return linear * self.scale[number] + self.bias[number]


def is_shader(found: Any) -> bool:
    """Whether `found`, from Textures.source, is a shader and its output rather than a value."""
    return isinstance(found, tuple) and isinstance(found[0], UsdShade.Shader)


@dataclass
class Textures:
    """The textures that a stage's materials use."""

    stage: Stage
    textures: list[Texture] = field(default_factory=list)
    _pixels: dict[str, Bytes] = field(default_factory=dict)
    _numbers: dict[tuple[Any, ...], int] = field(default_factory=dict)

    def source(self, shader_input: Any) -> Any:
        """What feeds `shader_input`: a value, None, or a shader with the name of its output."""
        producing = UsdShade.Utils.GetValueProducingAttributes(shader_input) if shader_input else []
        if not producing:
            return None
        name, kind = UsdShade.Utils.GetBaseNameAndType(producing[0].GetName())
        if kind == UsdShade.AttributeType.Output:
            return UsdShade.Shader(producing[0].GetPrim()), name
        return producing[0].Get(self.stage.time)

    def value(self, shader: Any, name: str, otherwise: Any) -> Any:
        """The value of the shader's input `name`, wherever it is set; `otherwise` if it has none or is computed."""
        found = self.source(shader.GetInput(name))
        return otherwise if found is None or is_shader(found) else found

    def uv_texture(self, shader: Any) -> UvTexture | None:
        """The texture of `shader`; None, and said, if it is no UsdUVTexture or its file is missing or broken."""
        if shader.GetShaderId() != "UsdUVTexture":
            self.stage.remarks.add(f"shaders of kind {shader.GetShaderId()} are not supported: defaults count instead")
            return None
        producing = UsdShade.Utils.GetValueProducingAttributes(shader.GetInput("file"))
        asset = producing[0].Get(self.stage.time) if producing else None
        if isinstance(asset, Sdf.AssetPath) and "<UDIM>" in asset.path:
            self.stage.remarks.add("textures of UDIM tiles are not supported and were left out", asset.path)
            return None
        found = self.stage.content(producing[0]) if isinstance(asset, Sdf.AssetPath) else None
        pixels = self._decoded(*found) if found else None
        if found is None or pixels is None:
            return None
        uv_name, transform = self._coordinates(shader)
        space = str(self.value(shader, "sourceColorSpace", "auto"))
        return UvTexture(
            found[0],
            pixels,
            np.array(self.value(shader, "scale", Gf.Vec4f(1.0)), np.float64),
            np.array(self.value(shader, "bias", Gf.Vec4f(0.0)), np.float64),
            {"sRGB": True, "raw": False}.get(space),
            (self._wrap(shader, "wrapS"), self._wrap(shader, "wrapT")),
            uv_name,
            transform,
        )

    def slot(self, texture: UvTexture, uv_set: int, srgb: bool) -> TextureSlot:
        """The slot that shows the pixels of `texture` as they are."""
        return self._slot(texture, (texture.file,), texture.pixels, uv_set, srgb)

    def composed(self, sources: list[Any], uv_set: int, srgb: bool) -> TextureSlot:
        """The slot of a texture whose four channels are made of `sources`: a number, or a texture and its channel.

        Numbers and channels are linear; with `srgb` the first three are encoded. At least one is a texture's, and the
        first of these says where all are.
        """
        used = [source[0] for source in sources if isinstance(source, tuple)]
        if any(
            (other.wraps, other.uv_name) != (used[0].wraps, used[0].uv_name)
            or not np.array_equal(other.transform, used[0].transform)
            for other in used
        ):
            self.stage.remarks.add("textures of one surface property are placed differently: the first's place counts")
        height, width = (max(texture.pixels.shape[axis] for texture in used) for axis in (0, 1))
        rows, columns = np.arange(height), np.arange(width)
        pixels = np.empty((height, width, 4), np.uint8)
        for number, source in enumerate(sources):
            values = np.array(source if not isinstance(source, tuple) else source[0].channel(source[1]))
            values = np.clip(values, 0.0, 1.0)
            if srgb and number < 3:
                values = np.where(values <= 0.0031308, values * 12.92, 1.055 * values ** (1 / 2.4) - 0.055)
            if values.ndim:
                h, w = values.shape
                values = values[(rows * h // height)[:, None], columns * w // width]
            pixels[..., number] = np.rint(values * 255.0)
        key = tuple(
            (s[0].file, s[1], *s[0].scale, *s[0].bias, s[0].encoded) if isinstance(s, tuple) else s for s in sources
        )
        return self._slot(used[0], key, pixels, uv_set, srgb)

    def _slot(self, placed: UvTexture, key: tuple[Any, ...], pixels: Bytes, uv_set: int, srgb: bool) -> TextureSlot:
        key = (*key, placed.wraps, srgb)
        if key not in self._numbers:
            name = placed.file.rstrip("]").replace("[", "/").rpartition("/")[2]
            self._numbers[key] = len(self.textures)
            self.textures.append(Texture(name, pixels, srgb, *placed.wraps))
        return TextureSlot(self._numbers[key], uv_set, slot_transform(placed.transform))

    def _decoded(self, file: str, content: bytes) -> Bytes | None:
        """The pixels of a file; None, and said, when it is no image that can be read."""
        if file not in self._pixels:
            stage, name = self.stage, file.rpartition("/")[2]
            try:
                self._pixels[file] = decode_image(content, str(stage.path), name, stage.limits)
            except ForbiddenError:
                raise
            except SceneError as error:
                stage.remarks.add(f"{error.problem}; it was left out", name)
                return None
            total = sum(pixels.size // 4 for pixels in self._pixels.values())
            limit = stage.limits.max_texture_pixels
            check_count(str(stage.path), "texture pixels", total, limit, "max_texture_pixels")
        return self._pixels[file]

    def _wrap(self, shader: Any, name: str) -> Wrap:
        mode = str(self.value(shader, name, "useMetadata"))
        if mode not in _WRAPS:
            self.stage.remarks.add(f"textures cannot be {mode!r} outside their edges: clamped instead")
        return _WRAPS.get(mode, Wrap.CLAMP)

    def _coordinates(self, shader: Any) -> tuple[str, Doubles]:
        """The primvar that places the texture of `shader`, and the 3×3 matrix of its coordinates (u, v, 1)."""
        found, transform = self.source(shader.GetInput("st")), np.eye(3)
        while is_shader(found) and found[0].GetShaderId() == "UsdTransform2d":
            node = found[0]
            angle = np.radians(float(self.value(node, "rotation", 0.0)))
            su, sv = self.value(node, "scale", (1.0, 1.0))
            u, v = self.value(node, "translation", (0.0, 0.0))
            cos, sin = np.cos(angle), np.sin(angle)
            transform = transform @ np.array([[cos * su, -sin * sv, u], [sin * su, cos * sv, v], [0.0, 0.0, 1.0]])
            found = self.source(node.GetInput("in"))
        if is_shader(found) and str(found[0].GetShaderId()).startswith("UsdPrimvarReader_float2"):
            return str(self.value(found[0], "varname", "st")) or "st", transform
        return "st", transform
