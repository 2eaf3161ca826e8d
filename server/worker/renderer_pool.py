"""Renderers kept on the device: one for each scene, size and settings in use, shared by all viewers who look at that.

Renders follow one another on a device, so viewers need no renderer of their own; what is a viewer's own is small. The
least recently used ones go when all together would take too much memory.
"""

from dataclasses import dataclass

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import Progress
from server.wire.worker import SceneRef

# Device memory of a renderer, nearly all in arrays of its pixels, of SP clusters and of pairs of clusters [bytes]; 591,
# 11,228 and 7.0 fitted to the arrays of six renderers.
BYTES_A_PIXEL = 610
BYTES_A_CLUSTER = 12_000
BYTES_A_PAIR = 8
# Of the device's memory, for all renderers; and on a CPU, whose memory others use too [bytes].
SHARE = 0.25
CPU_BYTES = 2 << 30
MOST = 64


@dataclass(frozen=True)
class _Key:
    scene: SceneRef
    size: tuple[int, int]
    settings: RenderSettings


class Renderers:
    """The renderers of one device, by what they render."""

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self._most_bytes = int(SHARE * device.total_memory) if device.is_cuda else CPU_BYTES
        self._kept: dict[_Key, Renderer] = {}  # in the order of their last use

    def get(
        self,
        scene: SceneRef,
        resident: DeviceScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress,
    ) -> Renderer:
        """The renderer of `scene`, which is on the device as `resident`; made when there is none yet."""
        key = _Key(scene, size, settings.model_copy(update={"frames": None}))
        renderer = self._kept.pop(key, None)
        if renderer is None:
            self._make_room(key)
            renderer = Renderer(resident, size, key.settings, progress)
            # Warp compiles a kernel at its first launch, and says nothing meanwhile.
            progress("compiling kernels, which the first time takes a minute", 0.0)
        self._kept[key] = renderer
        return renderer

    def drop(self, scene: SceneRef) -> None:
        """Free the renderers of a scene."""
        self._kept = {key: renderer for key, renderer in self._kept.items() if key.scene != scene}

    def clear(self) -> None:
        """Free all of them."""
        self._kept.clear()

    def __len__(self) -> int:
        return len(self._kept)

    def _bytes_of(self, key: _Key) -> int:
        quality = sample_counts_of(key.settings, self._device)
        clusters = BYTES_A_CLUSTER + BYTES_A_PAIR * quality.vpl_clusters
        return BYTES_A_PIXEL * key.size[0] * key.size[1] + clusters * quality.sp_clusters

    def _make_room(self, new: _Key) -> None:
        while self._kept and (
            len(self._kept) >= MOST or sum(map(self._bytes_of, [new, *self._kept])) > self._most_bytes
        ):
            del self._kept[next(iter(self._kept))]
