from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from server.video.film_file import FilmFile, check_film
from server.video.film_settings import FilmCodec, FilmSettings
from server.video.pictures import VideoError

av = pytest.importorskip("av", reason="the extra video is not installed")
SIZE, FPS, PICTURES = (96, 64), 24, 30
COLOURS = np.array([[(230, 20, 40), (20, 200, 60)], [(30, 40, 220), (128, 128, 128)]], np.uint8)


def picture(number: int) -> NDArray[np.uint8]:
    """Four colours, which go around, and a grey that grows."""
    corners = np.roll(COLOURS, number // 10, axis=1)
    pixels: NDArray[np.uint8] = corners.repeat(SIZE[1] // 2, axis=0).repeat(SIZE[0] // 2, axis=1)
    pixels[24:40, 32:64] = 8 * number
    return pixels


@pytest.mark.parametrize("codec", FilmCodec)
def test_a_film_is_what_was_put_in(codec: FilmCodec, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "film.mp4"
    with FilmFile(path, SIZE, FilmSettings(fps=FPS, codec=codec)) as film:
        for number in range(PICTURES):
            film.add(picture(number))
        assert not path.exists()
    assert [found.name for found in tmp_path.iterdir()] == ["film.mp4"]
    assert "".join(capfd.readouterr()) == ""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.average_rate) == ({"h264": "h264", "av1": "libdav1d"}[codec], FPS)
        frames = list(container.decode(stream))
        assert container.duration == pytest.approx(1e6 * PICTURES / FPS, abs=1e3)
    assert len(frames) == PICTURES
    assert [round(FPS * frame.time) for frame in frames] == list(range(PICTURES))
    for number, frame in enumerate(frames):
        assert (frame.width, frame.height) == SIZE
        assert (frame.color_primaries, frame.color_trc, frame.colorspace, frame.color_range) == (1, 13, 1, 1)
        errors = np.abs(frame.to_ndarray(format="rgb24").astype(int) - picture(number))
        assert np.median(errors) <= 3
        assert errors.mean() < 4.0  # with the edges, where neighbours share a colour


@pytest.mark.parametrize(("codec", "least", "most"), [(FilmCodec.H264, 35.0, 43.0), (FilmCodec.AV1, 40.5, 44.8)])
def test_details_are_kept_in_no_more_bytes_than_that_takes(
    codec: FilmCodec, least: float, most: float, tmp_path: Path
) -> None:
    """Half and double the number that decides quality are outside of these bounds."""
    path, rows, columns = tmp_path / "film.mp4", *np.mgrid[0:64, 0:96]
    waves = [np.sin((columns + 3 * n) / 5) * np.cos(rows / 7) + np.sin((columns - rows + n) / 3) for n in range(12)]
    pictures = [np.repeat((128 + 50 * wave)[..., None], 3, axis=2).astype(np.uint8) for wave in waves]
    with FilmFile(path, SIZE, FilmSettings(fps=FPS, codec=codec)) as film:
        for pixels in pictures:
            film.add(pixels)
    with av.open(str(path)) as container:
        shown = [frame.to_ndarray(format="rgb24").astype(float) for frame in container.decode(video=0)]
    mse = np.mean([(one - other) ** 2 for one, other in zip(shown, pictures, strict=True)])
    assert least < 10.0 * np.log10(255.0**2 / mse) < most


def test_a_player_can_begin_before_it_has_all(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with FilmFile(path, SIZE, FilmSettings(fps=FPS)) as film:
        for _ in range(3 * FPS):
            film.add(picture(0))
    content = path.read_bytes()
    assert 0 < content.index(b"moov") < content.index(b"mdat")
    with av.open(str(path)) as container:
        keys = [frame.time for frame in container.decode(video=0) if frame.key_frame]
    assert keys[:2] == [0.0, 2.0]


def test_a_film_that_fails_leaves_nothing_and_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    path.write_bytes(b"the film before")
    film = FilmFile(path, SIZE, FilmSettings(fps=FPS))
    film.add(picture(0))
    film.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert [(found.name, found.read_bytes()) for found in tmp_path.iterdir()] == [("film.mp4", b"the film before")]


def test_where_it_cannot_be_written_is_said(tmp_path: Path) -> None:
    path = tmp_path / "none" / "film.mp4"
    with pytest.raises(VideoError, match=r"^film\.mp4: cannot be written: No such file"):
        FilmFile(path, SIZE, FilmSettings(fps=FPS))


def test_its_bytes_are_counted(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 256, (SIZE[1], SIZE[0], 3), np.uint8)
    with FilmFile(tmp_path / "film.mp4", SIZE, FilmSettings(fps=FPS)) as film:
        for _ in range(200):
            film.add(noise)
        assert film.encoded_bytes > 1000


def test_what_is_missing_is_said_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(VideoError, match="even sides"):
        check_film((63, 48), FilmCodec.H264)
    with pytest.raises(VideoError, match=r"^size: av1 needs sides of 64 to 8192 pixels, not 8192x62$"):
        check_film((8192, 62), FilmCodec.AV1)
    with pytest.raises(VideoError, match="h264 needs sides of 2 to 16384"):
        check_film((16386, 2), FilmCodec.H264)

    def unknown(name: str, mode: str) -> None:
        raise av.codec.codec.UnknownCodecError(name)

    monkeypatch.setattr("av.codec.Codec", unknown)
    with pytest.raises(VideoError, match="no encoder libsvtav1 for av1; use h264"):
        check_film(SIZE, FilmCodec.AV1)
