"""Textures of a glTF file: images decoded once, joined with their samplers."""

from dataclasses import dataclass, field
from pathlib import PurePosixPath

from gpu.scene.files import read_uri
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.values import Value
from gpu.scene.images import decode_image
from gpu.scene.types import Bytes, Texture, Wrap
from gpu.scene.validate import check_count

_WRAPS = {10497: Wrap.REPEAT, 33071: Wrap.CLAMP, 33648: Wrap.MIRROR}
_NEAREST = 9728


@dataclass(frozen=True)
class Images:
    """The textures that a file uses. One used for colour and for data becomes two with the same pixels."""

    buffers: Buffers
    textures: list[Texture] = field(default_factory=list)
    _numbers: dict[tuple[str, bool], int] = field(default_factory=dict)
    _pixels: dict[str, Bytes] = field(default_factory=dict)

    def texture(self, info: Value, srgb: bool) -> int | None:
        """The number in `textures` of what the textureInfo names; None when it has no image that can be read.

        Raises SceneError when the texture, sampler or image is broken or too large.
        """
        document = self.buffers.document
        entry = document.referred(info, "index", "textures")
        if (entry.path, srgb) in self._numbers:
            return self._numbers[entry.path, srgb]
        source = entry.extension("EXT_texture_webp") or entry
        if not source.has("source"):
            document.say(f"{entry.path} has no PNG, JPEG or WebP image and was ignored")
            return None
        default = Value(entry.source, entry.path, {})
        sampler = document.referred(entry, "sampler", "samplers") if entry.has("sampler") else default
        pixels, name = self._image(source)
        wraps = [self._wrap(sampler, key) for key in ("wrapS", "wrapT")]
        nearest = sampler.integer("magFilter", 0) == _NEAREST
        self.textures.append(Texture(entry.text("name", "") or name, pixels, srgb, wraps[0], wraps[1], nearest))
        self._numbers[entry.path, srgb] = len(self.textures) - 1
        return self._numbers[entry.path, srgb]

    def _wrap(self, sampler: Value, key: str) -> Wrap:
        code = sampler.integer(key, 10497)
        if code not in _WRAPS:
            raise sampler.get(key).error(f"{code} is not a wrap mode")
        return _WRAPS[code]

    def _image(self, texture: Value) -> tuple[Bytes, str]:
        """Pixels (height, width, 4) and name of the image that is the texture's source."""
        document = self.buffers.document
        image = document.referred(texture, "source", "images")
        name = image.text("name", "")
        if not name and image.has("uri") and not image.text("uri").startswith("data:"):
            name = PurePosixPath(image.text("uri")).name
        if image.path not in self._pixels:
            if image.has("uri"):
                content = read_uri(document.path, image.text("uri"), f"{image.path}.uri", document.limits)
            else:
                content = bytes(self.buffers.view(image, "bufferView")[0])
            self._pixels[image.path] = decode_image(content, image.source, image.path, document.limits)
            total = sum(pixels.size // 4 for pixels in self._pixels.values())
            limit = document.limits.max_texture_pixels
            check_count(image.source, "texture pixels", total, limit, "max_texture_pixels")
        return self._pixels[image.path], name or image.path
