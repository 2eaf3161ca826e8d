"""Renderers kept on the device: one for each scene, size and settings in use, shared by all viewers who look at that.

Renders follow one another on a device, so viewers need no renderer of their own; what is a viewer's own is small. The
least recently used ones go when all together would take too much memory.
"""

from dataclasses import dataclass

import warp as wp

from gpu.lighting import Progress
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.settings import RenderSettings
from server.messages import SceneRef

# Device memory of a renderer, nearly all in arrays of its pixels' size [bytes a pixel]; 316 with default settings.
BYTES_A_PIXEL = 400
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
        budget = SHARE * device.total_memory if device.is_cuda else CPU_BYTES
        self._most_pixels = int(budget / BYTES_A_PIXEL)
        self._kept: dict[_Key, Renderer] = {}  # in the order of their last use

    def get(
        self,
        scene: SceneRef,
        resident: ResidentScene,
        size: tuple[int, int],
        settings: RenderSettings,
        progress: Progress,
    ) -> Renderer:
        """The renderer of `scene`, which is on the device as `resident`; made when there is none yet."""
        key = _Key(scene, size, settings.model_copy(update={"frames": None}))
        renderer = self._kept.pop(key, None)
        if renderer is None:
            self._make_room(size[0] * size[1])
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

    def _make_room(self, pixels: int) -> None:
        while self._kept and (
            len(self._kept) >= MOST or pixels + sum(key.size[0] * key.size[1] for key in self._kept) > self._most_pixels
        ):
            del self._kept[next(iter(self._kept))]
