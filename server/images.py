"""Image files: pictures for display (PNG, JPEG), linear radiance (OpenEXR, NPY), and reading the linear ones back."""

import io
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import OpenEXR
import simplejpeg
from numpy.typing import NDArray

from gpu.errors import ImageError
from gpu.scene.colors import REC_709
from gpu.settings import Component
from server.png import encode_png
from server.srgb_profile import SRGB_PROFILE

DISPLAY_FORMATS = (".png", ".jpg", ".jpeg")
LINEAR_FORMATS = (".exr", ".npy")
FORMATS = DISPLAY_FORMATS + LINEAR_FORMATS
JPEG_QUALITY = 92

# An APP2 segment, as ICC.1:2010, B.4 has it: the first chunk of one.
_ICC_DATA = b"ICC_PROFILE\0\1\1" + SRGB_PROFILE
_JPEG_SRGB = struct.pack(">HH", 0xFFE2, 2 + len(_ICC_DATA)) + _ICC_DATA


def encode_image(pixels: NDArray[np.uint8] | None, radiance: NDArray[np.float32] | None, suffix: str) -> bytes:
    """Return the bytes of an image file of the format that `suffix` (".png", ...) names.

    pixels: (height, width, 3) sRGB, for DISPLAY_FORMATS; radiance: (height, width, 3) linear Rec. 709, for
    LINEAR_FORMATS, kept as float32. The one that the format does not need may be None. PNG, JPEG and OpenEXR say whose
    colours they are; NPY has no place for that.
    Raises ImageError for another suffix; ValueError when what the format needs is None.
    """
    suffix = check_format(suffix)
    source = pixels if suffix in DISPLAY_FORMATS else radiance
    if source is None:
        raise ValueError(f"{suffix} needs {'pixels' if suffix in DISPLAY_FORMATS else 'radiance'}")
    image: NDArray[Any] = np.ascontiguousarray(source)
    stream = io.BytesIO()
    match suffix:
        case ".png":
            stream.write(encode_png(image))
        case ".exr":
            header = {
                "compression": OpenEXR.ZIP_COMPRESSION,
                "type": OpenEXR.scanlineimage,
                "chromaticities": REC_709,  # which readers assume without
            }
            OpenEXR.File(header, {"RGB": image.astype(np.float32)}).write(stream)
        case ".npy":
            np.save(stream, image.astype(np.float32), allow_pickle=False)
        case _:
            jpeg = simplejpeg.encode_jpeg(image, JPEG_QUALITY, colorspace="RGB", colorsubsampling="444")
            stream.write(_with_profile(jpeg))
    return stream.getvalue()


def _with_profile(jpeg: bytes) -> bytes:
    """A JPEG with the sRGB profile, after its APP0 segment, which must come first (JFIF 1.02)."""
    marker, length = struct.unpack(">HH", jpeg[2:6])
    place = 4 + length if marker == 0xFFE0 else 2
    return jpeg[:place] + _JPEG_SRGB + jpeg[place:]


def check_format(suffix: str) -> str:
    """Return `suffix` in lower case when it names a format that can be written; raises ImageError otherwise."""
    if suffix.lower() not in FORMATS:
        raise ImageError(f"{suffix or 'a file without a suffix'}: not an image format; choose one of {_words(FORMATS)}")
    return suffix.lower()


def check_output(path: Path) -> str:
    """Return the suffix, in lower case, of an image that can be written to `path`; raises ImageError otherwise."""
    try:
        suffix = check_format(path.suffix)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None
    check_folder(path)
    return suffix


def check_folder(path: Path) -> None:
    """ImageError where the folder of a file that is to be written is not there, or the file cannot be written there."""
    if not path.parent.is_dir():
        raise ImageError(f"{path}: the folder {path.parent} does not exist; make it first")
    if path.is_dir():
        raise ImageError(f"{path}: is a folder; name a file in it")
    if not os.access(path.parent, os.W_OK):
        raise ImageError(f"{path}: the folder {path.parent} cannot be written to; choose another one")


def read_image(path: Path, component: Component = Component.FULL) -> NDArray[np.float32]:
    """Return the linear radiance in an .npy, .exr or .npz file, shape (height, width, 3).

    `component` chooses from an .npz reference, which holds `full` and `direct` (indirect is their difference); other
    files hold one component, which is taken as it is. Raises ImageError for files that are missing, damaged, not
    linear (PNG and JPEG have been through a tone curve) or not RGB.
    """
    readers: dict[str, Callable[[Path], NDArray[np.floating]]] = {
        ".npy": _read_npy,
        ".exr": _read_exr,
        ".npz": lambda file: _read_reference(file, component),
    }
    suffix = path.suffix.lower()
    if suffix in DISPLAY_FORMATS:
        raise ImageError(f"{path}: {suffix} holds tone-mapped colours, not light; write .exr or .npy and use that")
    if suffix not in readers:
        raise ImageError(f"{path}: cannot be read as an image; use one of {_words(tuple(readers))}")
    try:
        image = readers[suffix](path)
    except OSError as error:
        raise ImageError(f"{path}: {error.strerror or 'cannot be read'}") from error
    except (ValueError, EOFError, MemoryError, BadZipFile, zlib.error, RuntimeError) as error:
        raise ImageError(f"{path}: not a readable {suffix} file: {error}") from error
    if image.ndim != 3 or image.shape[2] != 3 or image.size == 0 or not np.issubdtype(image.dtype, np.floating):
        raise ImageError(f"{path}: shape {image.shape} of {image.dtype}, expected (height, width, 3) of a float type")
    return image.astype(np.float32)


def write_atomic(path: Path, data: bytes) -> None:
    """Write `data` to `path` so that a reader, or a crash, never meets half a file. Raises ImageError if it cannot."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(data)
        temporary.replace(path)
    except OSError as error:
        raise ImageError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _read_npy(path: Path) -> NDArray[np.floating]:
    with path.open("rb") as file:
        image: NDArray[np.floating] = np.lib.format.read_array(file, allow_pickle=False)
    return image


def _read_exr(path: Path) -> NDArray[np.floating]:
    # OpenEXR only warns about damaged pixels, and leaves their channels out.
    with path.open("rb") as stream, OpenEXR.File(stream) as file:
        channels = file.channels()
        name = next((name for name in ("RGB", "RGBA") if name in channels), None)
        if name is None or channels[name].pixels is None:
            raise ImageError(f"{path}: has no readable channels R, G and B")
        image: NDArray[np.floating] = np.array(channels[name].pixels[..., :3])
    return image


def _read_reference(path: Path, component: Component) -> NDArray[np.floating]:
    with path.open("rb") as file, np.lib.npyio.NpzFile(file, allow_pickle=False) as arrays:
        wanted = ("full", "direct") if component is Component.INDIRECT else (component.value,)
        for name in wanted:
            if name not in arrays:
                raise ImageError(f"{path}: has no array {name!r}, which --component {component} needs")
        first, *rest = (arrays[name].astype(np.float32) for name in wanted)
    image: NDArray[np.floating] = first - rest[0] if rest else first
    return image


def _words(names: tuple[str, ...]) -> str:
    return ", ".join(names)
