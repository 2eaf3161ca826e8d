import io
import struct
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from numpy.typing import NDArray
from PIL import Image

from gpu.errors import ImageError
from gpu.settings import Component
from server.images import check_output, encode_image, read_image, write_atomic
from server.srgb_profile import SRGB_PROFILE

RNG = np.random.default_rng(5)
PIXELS = np.repeat(np.repeat(RNG.integers(0, 255, (4, 6, 3), np.uint8), 8, 0), 8, 1)
RADIANCE = (RNG.random((9, 13, 3)) ** 4 * 1000.0).astype(np.float32)


def test_png_keeps_every_pixel() -> None:
    with Image.open(io.BytesIO(encode_image(PIXELS, None, ".PNG"))) as image:
        assert image.mode == "RGB"
        assert np.array_equal(np.asarray(image), PIXELS)


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg_is_close_and_has_full_colour_resolution(suffix: str) -> None:
    data = encode_image(PIXELS, None, suffix)
    assert np.abs(simplejpeg.decode_jpeg(data).astype(int) - PIXELS).mean() < 2.0
    assert simplejpeg.decode_jpeg_header(data)[3] == "444"


@pytest.mark.parametrize("suffix", [".exr", ".npy"])
def test_linear_formats_come_back_bit_by_bit(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    write_atomic(path, encode_image(None, RADIANCE, suffix))
    back = read_image(path)
    assert back.dtype == np.float32
    assert np.array_equal(back, RADIANCE)


def test_png_says_that_it_is_srgb() -> None:
    data = encode_image(PIXELS, None, ".png")
    chunks, place = {}, 8
    while place < len(data):
        length, name = struct.unpack_from(">I4s", data, place)
        chunks[name] = data[place + 8 : place + 8 + length]
        place += 12 + length
    assert chunks[b"sRGB"] == b"\0"
    names = list(chunks)
    assert max(names.index(name) for name in (b"sRGB", b"gAMA", b"cHRM")) < names.index(b"IDAT")
    with Image.open(io.BytesIO(data)) as image:
        assert image.info["gamma"] == pytest.approx(1 / 2.2, abs=1e-4)
        assert image.info["chromaticity"] == pytest.approx((0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06))


def test_jpeg_has_the_profile_of_srgb() -> None:
    data = encode_image(PIXELS, None, ".jpg")
    assert data[2:4] == b"\xff\xe0"  # JFIF's own segment comes first
    with Image.open(io.BytesIO(data)) as image:
        assert image.info["icc_profile"] == SRGB_PROFILE
        assert image.info["jfif_version"]
        image.load()


def test_exr_tells_its_primaries_to_any_reader() -> None:
    data = encode_image(None, RADIANCE, ".exr")
    place = data.index(b"chromaticities\0chromaticities\0")
    size, *values = struct.unpack_from("<I8f", data, place + 30)
    assert size == 32
    assert values == pytest.approx((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))


def test_exr_names_channels_and_primaries(tmp_path: Path) -> None:
    import OpenEXR

    path = tmp_path / "a.exr"
    path.write_bytes(encode_image(None, RADIANCE, ".exr"))
    with OpenEXR.File(str(path), separate_channels=True) as file:
        assert set(file.channels()) == {"R", "G", "B"}
        assert file.header()["chromaticities"] == pytest.approx((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))


def test_reference_components(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    full, direct = np.full((2, 2, 3), 3.0, np.float16), np.full((2, 2, 3), 2.0, np.float16)
    np.savez(path, full=full, direct=direct)
    means = {component: read_image(path, component).mean() for component in Component}
    assert means == {Component.FULL: 3.0, Component.DIRECT: 2.0, Component.INDIRECT: 1.0}
    np.savez(path, full=full)
    with pytest.raises(ImageError, match="direct"):
        read_image(path, Component.INDIRECT)


def test_real_reference(shared: Path) -> None:
    path = shared / "references" / "cornell-box.npz"
    direct, indirect = read_image(path, Component.DIRECT), read_image(path, Component.INDIRECT)
    assert np.allclose(direct + indirect, read_image(path))
    assert indirect.mean() > 0.01


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("missing.npy", None),
        ("missing.exr", None),
        ("text.npy", b"hello"),
        ("text.npz", b"hello"),
        ("single.npz", encode_image(None, RADIANCE, ".npy")),
        ("empty.npz", b""),
        ("text.exr", b"hello"),
        ("cut.npy", encode_image(None, RADIANCE, ".npy")[:-9]),
        ("cut.exr", encode_image(None, RADIANCE, ".exr")[:-99]),
        ("display.png", encode_image(PIXELS, None, ".png")),
        ("scene.glb", b"glTF"),
        ("a", b""),
    ],
)
def test_unreadable_files_are_said_by_name(name: str, data: bytes | None, tmp_path: Path) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(ImageError, match=name):
        read_image(tmp_path / name)


@pytest.mark.parametrize("array", [np.zeros((4, 4)), np.zeros((4, 4, 4)), np.zeros((2, 2, 3), np.uint8)])
def test_arrays_that_are_not_rgb_radiance_are_refused(array: NDArray[np.float64], tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(ImageError, match="expected"):
        read_image(tmp_path / "a.npy")


def test_an_array_that_is_larger_than_memory_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "large.npy").open("wb") as file:
        shape = {"descr": "<f4", "fortran_order": False, "shape": (2**40, 2**9, 3)}
        np.lib.format.write_array_header_1_0(file, shape)
    with pytest.raises(ImageError, match=r"large\.npy"):
        read_image(tmp_path / "large.npy")


def test_pickles_are_not_run(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(ImageError, match="Object arrays"):
        read_image(tmp_path / "a.npy")


def test_other_formats_are_refused() -> None:
    with pytest.raises(ImageError, match=r"\.tiff"):
        encode_image(PIXELS, RADIANCE, ".tiff")


def test_write_replaces_whole_files_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.png"
    write_atomic(path, b"old")
    write_atomic(path, b"new")
    assert path.read_bytes() == b"new"

    def full_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full_disk)
    with pytest.raises(ImageError, match="No space left"):
        write_atomic(path, b"newer")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_an_output_that_cannot_be_written_is_said_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert check_output(tmp_path / "a.PNG") == ".png"
    (tmp_path / "folder.png").mkdir()
    for name, sentence in {
        "no/a.png": "the folder .*no does not exist",
        "folder.png": "folder.png: is a folder; name a file in it",
        "a": "a: a file without a suffix: not an image format",
    }.items():
        with pytest.raises(ImageError, match=sentence):
            check_output(tmp_path / name)
    monkeypatch.setattr("server.images.os.access", lambda *_: False)
    with pytest.raises(ImageError, match="cannot be written to"):
        check_output(tmp_path / "a.png")
