"""Textures of a glTF file: images decoded once, joined with their samplers."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import PurePosixPath

from gpu.scene.formats.files import read_uri
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.values import Value
from gpu.scene.formats.images import decode_image
from gpu.scene.formats.ktx2 import IDENTIFIER, decode_ktx2
from gpu.scene.types import Bytes, Texture, Wrap
from gpu.scene.validate import check_count

_WRAPS = {10497: Wrap.REPEAT, 33071: Wrap.CLAMP, 33648: Wrap.MIRROR}
_NEAREST, _LINEAR = 9728, 9729


@dataclass(frozen=True)
class Images:
    """The textures that a file uses. One used for colour and for data becomes two with the same pixels."""

    buffers: Buffers
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[tuple[str, bool], int] = field(default_factory=dict)
    _pixels: dict[str, Bytes | None] = field(default_factory=dict)

    def texture(self, info: Value, srgb: bool) -> int | None:
        """The number in `textures` of what the textureInfo names; None, and said, when it has no image.

        Raises SceneError when there is no such texture, and ForbiddenError.
        """
        entry = self.buffers.document.referred(info, "index", "textures")
        key = (entry.path, srgb)
        if key not in self._numbers:
            texture = self._texture(entry, srgb)
            if texture is None:
                return None
            self.textures.append(texture)
            self._numbers[key] = len(self.textures) - 1
        return self._numbers[key]

    def _texture(self, entry: Value, srgb: bool) -> Texture | None:
        document = self.buffers.document
        packed = [entry.named_extension(name) for name in ("KHR_texture_basisu", "EXT_texture_webp")]
        sources = [place for place in (*packed, entry) if place.has("source")]
        if not sources:
            document.ignored.add("has no PNG, JPEG, WebP or KTX2 image and was ignored", entry.path)
        for source in sources:
            image = document.attempt(partial(document.referred, source, "source", "images"), "the image")
            pixels = self._image(image) if image is not None else None
            if image is not None and pixels is not None:
                sampler = self._sampler(entry)
                wraps = [sampler.choice(key, _WRAPS, Wrap.REPEAT) for key in ("wrapS", "wrapT")]
                nearest = sampler.choice("magFilter", {_NEAREST: True, _LINEAR: False}, False)
                return Texture(entry.name(_name(image) or image.path), pixels, srgb, wraps[0], wraps[1], nearest)
        return None

    def _sampler(self, entry: Value) -> Value:
        """The texture's sampler, one without settings where it has none."""
        document, default = self.buffers.document, Value(entry.source, entry.path, {})
        if not entry.has("sampler"):
            return default
        return entry.mended(
            lambda: document.referred(entry, "sampler", "samplers"), default, "the texture repeats, filtered"
        )

    def _image(self, image: Value) -> Bytes | None:
        """Pixels (height, width, 4) of an image, read once; None, and said, when it cannot be read."""
        if image.path not in self._pixels:
            self._pixels[image.path] = self.buffers.document.attempt(partial(self._decoded, image), "the image")
            total = sum(pixels.size // 4 for pixels in self._pixels.values() if pixels is not None)
            limit = self.buffers.document.limits.max_texture_pixels
            check_count(image.source, "texture pixels", total, limit, "max_texture_pixels")
        return self._pixels[image.path]

    def _decoded(self, image: Value) -> Bytes:
        document = self.buffers.document
        if image.has("uri"):
            uri, field = image.text("uri"), f"{image.path}.uri"
            content = read_uri(document.path, uri, field, document.limits, document.notes)
        else:
            content = bytes(self.buffers.view(image, "bufferView")[0])
        name = _name(image)
        field = f"{image.path} {name!r:.60}" if name else image.path
        decode = decode_ktx2 if content.startswith(IDENTIFIER) else decode_image
        return decode(content, image.source, field, document.limits)


def _name(image: Value) -> str:
    """What an image is called: its name, or that of its file."""
    uri = image.raw.get("uri", "")
    beside = isinstance(uri, str) and not uri.startswith("data:")
    return image.name(PurePosixPath(uri).name if beside else "")
