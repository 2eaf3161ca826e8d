"""Where the time of one viewer's frames goes: told to the metrics, and to the log when it is long."""

import logging

from server.metrics import Metrics
from server.rate_limit import Bucket
from server.wire.browser import Ack
from server.wire.frame_header import FrameHeader
from server.wire.worker import Done

SLOW_MS, SLOW_RATE = 1000.0, 0.1  # frames that took longer are logged, so many a second of one viewer
log = logging.getLogger("lumenwalk.viewer")


class FrameTimes:
    """The times of frames that were sent and not yet acknowledged."""

    def __init__(self, metrics: Metrics) -> None:
        self._metrics = metrics
        self._server_ms: dict[int, float] = {}  # that the server took, by unacknowledged frame
        self._slow = Bucket(SLOW_RATE, 1.0)

    def sending(self, header: FrameHeader) -> None:
        """A frame is about to be sent; its acknowledgement may come before `sent`."""
        self._server_ms[header.frame] = header.queue_ms + header.render_ms + header.encode_ms

    def sent(self, header: FrameHeader, done: Done, size: int) -> None:
        """A frame of `size` bytes is on its way."""
        queue, render, encode = header.queue_ms, header.render_ms, header.encode_ms
        self._metrics.frame(queue, render, encode, size, header.phase, done.stage_ms, done.skips)
        if queue + render + encode > SLOW_MS and self._slow.spend():
            times = {"queue_ms": queue, "render_ms": render, "encode_ms": encode}
            log.warning("slow frame", extra={"frame": header.frame, **times})

    def acknowledged(self, ack: Ack) -> None:
        """A viewer has shown a frame; what of its age is not the server's or the viewer's own was the network's."""
        spent = self._server_ms.get(ack.frame)
        self._server_ms = {frame: ms for frame, ms in self._server_ms.items() if frame > ack.frame}
        network = None
        if ack.age_ms is not None and spent is not None:
            network = max(ack.age_ms - spent - (ack.decode_ms or 0.0), 0.0)
        self._metrics.acknowledged(ack.age_ms, network, ack.decode_ms)
