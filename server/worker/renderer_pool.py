"""Renderers kept on the device: one for each state of a scene, size and settings in use, and each lane of the device,
shared by all in that lane who look at it.

Renders of a lane follow one another, so its viewers need no renderer of their own. What a walk leaves behind is the
viewer's own, though: a `ViewState` for each renderer that it uses, freed when it leaves or looks at something else.
When all together would take too much memory, the renderers that were not used for longest go, with the views of them.
"""

from collections import Counter
from dataclasses import dataclass, field
from math import sqrt

import warp as wp

from gpu.core.lane import Lane, frames_at_once
from gpu.device_scene.features import SceneFeatures
from gpu.errors import OutOfMemoryError
from gpu.methods.registry import method_of
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import Progress
from server.wire.worker import STILLS, SceneRef
from server.worker.loaded_scene import LoadedScene
from server.worker.memory import free_bytes

# Of the device's memory, for all renderers; and on a CPU, whose memory others use too [bytes].
SHARE = 0.4
CPU_BYTES = 2 << 30
MOST = 64  # in a lane
# Lanes for each frame that may be on the device at once, where that is several: then viewers who share a lane, while
# others have one alone, still get as many frames as those.
LANES_A_FRAME = 2
PICTURE_BYTES = 40  # a pixel: a mean of frames, and the picture on the host as it is encoded
FEW_BYTES = 64 << 20  # less is not worth asking for what there is
# Of one scene and settings, that a viewer has: it walks at one size and rests at another, in either of two states that
# take turns where several see the same edits.
VIEWS_A_VIEWER = 4


def lasting(settings: RenderSettings) -> RenderSettings:
    """What a renderer knows of settings: how many frames are averaged is not its concern."""
    return settings if settings.frames is None else settings.model_copy(update={"frames": None})


@dataclass(frozen=True)
class _Key:
    scene: SceneRef
    size: tuple[int, int]
    settings: RenderSettings
    features: SceneFeatures  # of the scene, which tell how much memory it takes
    state: int = 0  # the number of its LoadedScene, whatever its edits
    lane: int = 0


def _key(lane: int, scene: LoadedScene, size: tuple[int, int], settings: RenderSettings) -> _Key:
    features = scene.features(lambertian=settings.lambertian)
    return _Key(scene.ref, size, lasting(settings), features, scene.number, lane)


@dataclass
class _Entry:
    renderer: Renderer
    views: dict[int, ViewState] = field(default_factory=dict)  # by viewer, in the order of their last use


class RendererPool:
    """The renderers of one device by what they render, and what viewers have of them.

    frames: how many may be on the device at once.
    """

    def __init__(self, device: wp.Device, frames: int | None = None, *, downloads: bool = False) -> None:
        """frames: that may be on the device at once; None: as many as suit it; downloads: as of Renderer."""
        self._downloads, self._device = downloads, device
        self.frames = frames or frames_at_once(device)
        self._lanes = [Lane(device) for _ in range(LANES_A_FRAME * self.frames if self.frames > 1 else 1)]
        self._lane_of: dict[int, int] = {}  # by viewer
        self._most_bytes = int(SHARE * device.total_memory) if device.is_cuda else CPU_BYTES
        self._entries: dict[_Key, _Entry] = {}  # in the order of their last use

    def lane_of(self, viewer: int) -> int:
        """The number of a viewer's lane: of those with fewest viewers when it comes; all stills are in the first."""
        if viewer <= STILLS:
            return 0
        if viewer not in self._lane_of:
            crowds = Counter(self._lane_of.values())
            self._lane_of[viewer] = min(range(len(self._lanes)), key=lambda lane: crowds[lane])
        return self._lane_of[viewer]

    def get(
        self,
        viewer: int,
        lane: int,
        scene: LoadedScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress,
    ) -> tuple[Renderer, ViewState]:
        """The renderer of a scene at a size with these settings in a lane, and the viewer's view of it.

        Both are made when there are none yet. Views that the viewer has of other scenes and settings are freed.
        Raises OutOfMemoryError, with a size that would do, where the device has too little memory left.
        """
        if (found := self.find(viewer, lane, scene, size, settings)) is not None:
            return found
        key = _key(lane, scene, size, settings)
        self._leave_others(viewer, key)
        entry = self._entries.pop(key, None)
        views = entry.views if entry else {}
        self._make_room(key, views)
        self._check_memory(key, self._bytes_of(key, 1) - (self._bytes_of(key, 0) if entry else 0))
        if entry is None:
            shared = scene.device_scene, size, key.settings, progress, scene.light_sets
            entry = _Entry(Renderer(*shared, self._lanes[lane], downloads=self._downloads))
            # Warp compiles a kernel at its first launch, and says nothing meanwhile.
            progress("compiling kernels, which the first time takes a minute", 0.0)
        self._entries[key] = entry
        entry.views[viewer] = view = entry.renderer.new_view()
        return entry.renderer, view

    def find(
        self, viewer: int, lane: int, scene: LoadedScene, size: tuple[int, int], settings: RenderSettings
    ) -> tuple[Renderer, ViewState] | None:
        """What `get` returns, where it is there already."""
        key = _key(lane, scene, size, settings)
        entry = self._entries.get(key)
        if entry is None or viewer not in entry.views:
            return None
        self._leave_others(viewer, key)
        self._entries[key] = self._entries.pop(key)
        entry.views[viewer] = view = entry.views.pop(viewer)
        return entry.renderer, view

    def leave(self, viewer: int) -> None:
        """Free a viewer's views, and its place in a lane."""
        self._lane_of.pop(viewer, None)
        for entry in self._entries.values():
            entry.views.pop(viewer, None)

    def drop(self, scene: SceneRef) -> None:
        """Free the renderers of a scene, and the views of them."""
        self._entries = {key: entry for key, entry in self._entries.items() if key.scene != scene}

    def drop_state(self, state: LoadedScene) -> None:
        """Free the renderers of one state of a scene, and the views of them."""
        self._entries = {key: entry for key, entry in self._entries.items() if key.state != state.number}

    def discard(self, renderer: Renderer) -> None:
        """Free one renderer, and the views of it."""
        self._entries = {key: entry for key, entry in self._entries.items() if entry.renderer is not renderer}

    def clear(self) -> None:
        """Free all of them."""
        self._entries.clear()

    def __len__(self) -> int:
        return len(self._entries)

    def _leave_others(self, viewer: int, key: _Key) -> None:
        """Free a viewer's views of other scenes and settings than those of `key`, and all but the last of the same."""
        others = [other for other, entry in self._entries.items() if viewer in entry.views and other != key]
        alike = [other for other in others if (other.scene, other.settings) == (key.scene, key.settings)]
        for other in {*others} - {*alike[max(len(alike) - VIEWS_A_VIEWER + 1, 0) :]}:
            del self._entries[other].views[viewer]

    def _make_room(self, key: _Key, views: dict[int, ViewState]) -> None:
        """Free what was not used for longest until a renderer of `key`, which has `views`, and one more view fit in."""

        def is_full() -> bool:
            held = [(key, len(views) + 1), *((other, len(entry.views)) for other, entry in self._entries.items())]
            return len(held) > MOST * len(self._lanes) or sum(self._bytes_of(*one) for one in held) > self._most_bytes

        while self._entries and is_full():
            del self._entries[next(iter(self._entries))]
        while views and is_full():
            del views[next(iter(views))]

    def _check_memory(self, key: _Key, needed: int) -> None:
        (width, height), pixels = key.size, key.size[0] * key.size[1]
        needed += PICTURE_BYTES * pixels
        if needed < FEW_BYTES or needed <= (free := free_bytes(self._device)):
            return
        share = sqrt(free / needed)
        most = f"{max(int(share * width), 1)}×{max(int(share * height), 1)}"
        raise OutOfMemoryError(
            f"{width}×{height} pixels with these settings need about {needed / 1e9:.1f} GB of memory, of which "
            f"{free / 1e9:.1f} GB are free: ask for at most {most}, or for fewer clusters"
        )

    def _bytes_of(self, key: _Key, views: int) -> int:
        """Device memory of a renderer and so many views of it, as its method tells."""
        pixels, method = key.size[0] * key.size[1], method_of(key.settings)
        counts = sample_counts_of(key.settings, self._device)
        shared, own = method.cluster_bytes(counts)
        shared += method.caustic_bytes(key.features, counts)
        a_pixel, a_view_pixel = method.bytes_a_pixel(key.features)
        return a_pixel * pixels + shared + views * (a_view_pixel * pixels + own)
