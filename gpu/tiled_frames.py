"""Frames that are pictures of several viewers: a tile each, of one image, which all stages have in common.

A small picture takes a GPU as long as one of many times its pixels, since its launches are too small and wait for each
other, and the host as long as any. So pictures of one size of a scene, by one choice of settings, are rendered
together. Each viewer's walk has its own camera, samples of direct light, light and pictures of frames before, exposure
and brightness; what screen space shares stops at tiles. SP clusters are points of the scene and serve all tiles, as
many times as one has them, so a picture differs from that of its viewer alone by as much as clusters differ.
"""

from collections.abc import Mapping

from gpu.film.frame import Frame
from gpu.renderer import Renderer
from gpu.scene.types import Camera

# Frames in a row that a viewer who sits is not asked for: they cost others about its share of them.
MOST_ABSENT = 30


class TiledFrames:
    """Seats viewers, who are known by numbers, at the `tiles` of a renderer's frames, as they come and go."""

    def __init__(self, renderer: Renderer) -> None:
        """renderer: of several tiles, and of nobody else's frames."""
        self._renderer, self._view = renderer, renderer.new_view()
        self._viewers: list[int | None] = [None] * renderer.tiles
        self._absent: dict[int, int] = {}  # for how many frames, by viewer

    @property
    def free(self) -> int:
        """How many viewers more there are tiles for."""
        return self._viewers.count(None)

    def __contains__(self, viewer: int) -> bool:
        return viewer in self._viewers

    def sit(self, viewer: int) -> None:
        """Give a viewer a tile, if it has none and there is one left."""
        if viewer not in self._viewers and self.free:
            self._viewers[self._viewers.index(None)] = viewer

    def leave(self, viewer: int) -> None:
        """Give a viewer's tile back; nothing happens where it has none."""
        if viewer in self._viewers:
            tile = self._viewers.index(viewer)
            self._viewers[tile] = None
            self._view.walks[tile].last = None
            self._absent.pop(viewer, None)

    def render(self, cameras: Mapping[int, Camera]) -> dict[int, Frame]:
        """The next pictures of viewers' walks. Who comes new is seated, and has none if no tile is left.

        Those who sit and are not among them look on from where they are, so that their walks go on; after MOST_ABSENT
        such frames their tile is given back.
        """
        for viewer, absent in list(self._absent.items()):
            if absent == MOST_ABSENT and viewer not in cameras:
                self.leave(viewer)
        for viewer in cameras:
            self.sit(viewer)
        viewers = list(self._viewers)  # while the frame is under way, some may come and go
        self._absent = {it: self._absent.get(it, 0) + 1 for it in viewers if it is not None and it not in cameras}
        lasts = [walk.last for walk in self._view.walks]
        places = [last if it is None else cameras.get(it, last) for it, last in zip(viewers, lasts, strict=True)]
        frames = dict(zip(viewers, self._renderer.render_tiles(places, self._view), strict=True))
        return {viewer: frame for viewer in cameras if (frame := frames.get(viewer)) is not None}
