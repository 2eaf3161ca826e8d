import numpy as np
import pytest
from numpy.typing import NDArray

from server.video import live_video
from server.video.live_video import LiveVideo, can_encode_video
from server.video.pictures import av_library

SIZE = 96, 64


def picture(shift: int = 0, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """A colour ramp that moves to the left."""
    width, height = size
    x, y = np.meshgrid(np.arange(width) + shift, np.arange(height))
    return np.stack([2 * x % 256, 3 * y % 256, 128 + 0 * x], axis=-1).astype(np.uint8)


def decoded(*chunks: bytes) -> list[NDArray[np.uint8]]:
    """The pictures of a stream, each of which comes out as soon as its bytes are in."""
    av = av_library()
    context = av.CodecContext.create("h264", "r")
    context.flags |= av.codec.context.Flags.low_delay
    context.thread_type = "SLICE"
    pictures = [frame for chunk in (*chunks, None) for frame in context.decode(av.Packet(chunk) if chunk else None)]
    return [frame.to_ndarray(format="rgb24") for frame in pictures]


def test_pictures_come_back_one_a_chunk_and_only_the_first_is_whole() -> None:
    video = LiveVideo()
    chunks = [video.encode(1, number, picture(number)) for number in (1, 2, 3, 4)]
    assert [is_key for _, is_key in chunks] == [True, False, False, False]
    pictures = decoded(*(data for data, _ in chunks))
    assert len(pictures) == 4
    for number, shown in enumerate(pictures, 1):
        inside = np.s_[8:-8, 8:-24]  # away from where the ramp begins anew
        assert np.abs(shown[inside].astype(int) - picture(number)[inside]).mean() < 6.0
    assert len(chunks[3][0]) < len(chunks[0][0]) / 2


@pytest.mark.parametrize(("number", "size"), [(1, SIZE), (3, SIZE), (2, (64, 32))])
def test_what_does_not_follow_on_is_whole(number: int, size: tuple[int, int]) -> None:
    video = LiveVideo()
    video.encode(1, 1, picture())
    data, is_key = video.encode(1, number, picture(size=size))
    assert is_key
    assert decoded(data)[0].shape == (size[1], size[0], 3)


def test_viewers_have_videos_of_their_own_until_they_leave() -> None:
    video = LiveVideo()
    assert [video.encode(viewer, 1, picture())[1] for viewer in (1, 2)] == [True, True]
    video.forget(1)
    assert [video.encode(viewer, 2, picture())[1] for viewer in (1, 2)] == [True, False]


def test_odd_sides_become_even_by_their_last_pixels() -> None:
    odd = picture(size=(33, 17))
    shown = decoded(LiveVideo().encode(1, 1, odd)[0])[0]
    assert shown.shape == (18, 34, 3)
    assert np.abs(shown[:17, :33].astype(int) - odd).mean() < 12.0


def test_it_takes_pyav(monkeypatch: pytest.MonkeyPatch) -> None:
    assert can_encode_video()
    monkeypatch.setattr(live_video, "find_spec", lambda _: None)
    assert not can_encode_video()
