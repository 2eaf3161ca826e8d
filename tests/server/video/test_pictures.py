import sys

import numpy as np
import pytest

from server.video.pictures import PIXEL_FORMAT, VideoError, av_library, check_size, video_frame


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(VideoError, match=r"^video needs the extra video: pip install lumenwalk\[video\]$"):
        av_library()


@pytest.mark.parametrize(("size", "instead"), [((63, 36), "64x36"), ((64, 35), "64x36"), ((1, 1), "2x2")])
def test_odd_sides_are_refused_with_those_that_would_do(size: tuple[int, int], instead: str) -> None:
    with pytest.raises(VideoError, match=f"^size: a video needs even sides, .*; ask for {instead}$"):
        check_size(size)
    check_size((64, 36))


@pytest.mark.parametrize(
    ("colour", "coded"),
    # E'Y, E'CB and E'CR of BT.709-6, items 3.2 to 3.5, for 8 bits
    [
        ((255, 255, 255), (235, 128, 128)),
        ((0, 0, 0), (16, 128, 128)),
        ((255, 0, 0), (63, 102, 240)),
        ((0, 255, 0), (173, 42, 26)),
        ((0, 0, 255), (32, 240, 118)),
    ],
)
def test_colours_become_those_of_bt_709(colour: tuple[int, int, int], coded: tuple[int, int, int]) -> None:
    pytest.importorskip("av", reason="the extra video is not installed")
    picture = np.full((4, 8, 3), colour, np.uint8)
    frame = video_frame(picture)
    assert frame.format.name == PIXEL_FORMAT
    planes = [np.frombuffer(plane, np.uint8)[0] for plane in frame.planes]
    assert np.abs(np.subtract(planes, coded, dtype=int)).max() <= 1
