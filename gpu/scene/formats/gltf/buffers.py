"""Bytes of a glTF file: buffers from the GLB, data URIs or files beside it, and the views into them."""

from dataclasses import dataclass, field
from functools import partial

from gpu.scene.formats.files import read_uri
from gpu.scene.formats.gltf.document import Document
from gpu.scene.formats.gltf.meshopt import packed_view, unpack_view
from gpu.scene.formats.gltf.values import Value


@dataclass(frozen=True)
class Buffers:
    """The buffers of `document`, each read when first used."""

    document: Document
    _read: dict[str, memoryview] = field(default_factory=dict)

    def view(self, place: Value, key: str) -> tuple[memoryview, int]:
        """Bytes and stride (0 for none) of the buffer view that `place` names at `key`. Raises SceneError."""
        view = self.document.referred(place, key, "bufferViews")
        stride = view.integer("byteStride", 0, 4, 252) if view.has("byteStride") else 0
        packed = packed_view(view)
        if packed is not None:
            unpack = partial(self._unpacked, view, packed)
            spare = self.document.referred(view, "buffer", "buffers").has("uri")  # what is not packed is there as well
            data = self.document.attempt(unpack, "its packed copy") if spare else unpack()
            if data is not None:
                return data, stride
        return self._slice(view), stride

    def _unpacked(self, view: Value, packed: Value) -> memoryview:
        if view.path not in self._read:
            self._read[view.path] = unpack_view(packed, self._slice(packed), self.document.limits)
        return self._read[view.path]

    def _slice(self, view: Value) -> memoryview:
        """The bytes of a buffer that `view`, or its extension, names."""
        buffer = self._buffer(view)
        start, length = view.integer("byteOffset", 0), view.integer("byteLength", low=1)
        if start + length > len(buffer):
            raise view.error(f"bytes {start} to {start + length} of a buffer of {len(buffer)} bytes")
        return buffer[start : start + length]

    def _buffer(self, view: Value) -> memoryview:
        number = view.raw.get("buffer")
        if type(number) is int and (read := self._read.get(f"buffers[{number}]")) is not None:
            return read
        buffer = self.document.referred(view, "buffer", "buffers")
        if buffer.path not in self._read:
            self._read[buffer.path] = self._content(buffer)
        return self._read[buffer.path]

    def _content(self, buffer: Value) -> memoryview:
        length = buffer.integer("byteLength", low=1)
        if buffer.has("uri"):
            field = f"{buffer.path}.uri"
            content = read_uri(self.document.path, buffer.text("uri"), field, self.document.limits, self.document.notes)
        elif buffer.path == "buffers[0]" and self.document.binary is not None:
            content = self.document.binary
        else:
            raise buffer.error("has no 'uri', and the file has no binary chunk for it")
        if len(content) < length:
            raise buffer.error(f"has {len(content)} of {length} bytes; the data is cut off")
        return memoryview(content)[:length]
