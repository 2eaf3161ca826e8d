"""Walkers who have frames together: those whose turns are due when a frame begins are its tiles (gpu.tiled_frames).

Whoever comes while the last frame is on the device joins the next one. Nobody waits for anybody who has not come.
"""

from dataclasses import dataclass

from gpu.core.sharing import DEVICE_SHARING
from gpu.film.frame import Frame
from gpu.renderer import Renderer
from gpu.scene.types import Camera
from gpu.tiled_frames import TiledFrames

# A frame is of so many pixels at most, of which a GPU makes good use, and of so many tiles.
FRAME_PIXELS, MOST_TILES = 1 << 20, 16


def tiles_of(size: tuple[int, int]) -> int:
    """How many pictures of a size are to be tiles of one frame."""
    return max(min(FRAME_PIXELS // (size[0] * size[1]), MOST_TILES), 1)


class LostFrameError(Exception):
    """The picture was to be a tile of a frame that was broken off, or found no tile; it is to be asked for again."""


@dataclass(eq=False)
class _Wish:
    """A picture that a viewer wants, until there is its `frame`, or until it is lost."""

    viewer: int
    camera: Camera
    frame: Frame | None = None
    lost: bool = False


class Table:
    """Viewers who sit at the tiles of a renderer's frames. broken: it is not to be used any more."""

    def __init__(self, renderer: Renderer) -> None:
        self.tiles = TiledFrames(renderer)
        self._count = renderer.tiles
        self._wishes: list[_Wish] = []
        self._busy = self.broken = False

    def render(self, viewer: int, camera: Camera) -> Frame:
        """The next picture of a viewer's walk, which stays as it is.

        An error while it is rendered breaks the table; others whose pictures that takes get a LostFrameError.
        """
        wish = _Wish(viewer, camera)
        self._wishes.append(wish)
        try:
            while wish.frame is None:
                DEVICE_SHARING.wait_for(lambda: not self._busy or wish.frame is not None)
                if wish.lost:
                    raise LostFrameError
                if wish.frame is None:
                    self._serve(wish)
        finally:
            self._wishes.remove(wish)
        return wish.frame

    def _serve(self, first: _Wish) -> None:
        """Render a frame for one who wishes, and for as many others as there are tiles."""
        others = [wish for wish in self._wishes if wish is not first and wish.frame is None]
        served = [first, *others][: self._count]
        self._busy = True
        try:
            frames = self.tiles.render({wish.viewer: wish.camera for wish in served})
        except BaseException:
            self.broken = True
            for wish in self._wishes:
                wish.lost = True
            raise
        finally:
            self._busy = False
        for wish in served:
            wish.frame = frames.get(wish.viewer)
            wish.lost = wish.frame is None  # its viewer has left, and another has the tile
