"""A server's part played by the test: what the page says is noted, and it is answered word by word."""

import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import simplejpeg
from harness import Running
from numpy.typing import NDArray
from playwright.sync_api import Page, WebSocketRoute, expect

from gpu.settings import RenderSettings
from server.images import encode_image
from server.video.live_video import LiveVideo
from server.wire.browser import PROTOCOL, SceneInfo
from server.wire.frame_header import Codec, FrameHeader, Phase

IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
FRONT = {"name": "front", "matrix": IDENTITY, "yfov": 1.0, "aspect": 1.6, "orthographic": False, "near": 0.0}
LAMP = {"id": "lamp", "form": "surface", "color": [1.0, 0.5, 0.25]}
WALL = {"id": "wall", "color": [1.0, 1.0, 1.0], "roughness": 1.0, "metallic": 0.0, "emission": [0.0, 0.0, 0.0]}
SCENES = [
    {"id": "cornell-box", "name": "cornell-box", "builtin": True, "served": True},
    {"id": "hall.glb", "name": "hall", "builtin": False, "served": False},
]
STAGES = {"gbuffer": 0.5, "cluster": 2.0, "shade": 1.0, "correct": 3.0, "direct": 1.5, "display": 0.2}


class Stage:
    """Every WebSocket of a page."""

    def __init__(self, page: Page) -> None:
        self.heard: list[dict[str, Any]] = []  # what the page said on the newest connection
        self.connections = 0
        self.away = False  # a server that takes nobody now
        self.run = "first"  # of the service
        self.takes_edits = True
        self.gives_exports = False
        self.closes: list[int | None] = []
        self.page = page
        self._frame = 0
        self._video = LiveVideo()
        self._socket: WebSocketRoute | None = None
        page.route_web_socket(re.compile("/api/v1/stream"), self._open)

    def _open(self, socket: WebSocketRoute) -> None:
        self._socket = socket
        self._frame = 0
        self.connections += 1
        if self.away:
            socket.close(code=1012)
        self.heard = []
        socket.on_message(lambda message: self.heard.append(json.loads(message)))
        socket.on_close(lambda code, _: self.closes.append(code))

    def all(self, type_: str) -> list[dict[str, Any]]:
        """What the page said of this type, the newest last."""
        return [message for message in self.heard if message["type"] == type_]

    def hear(self, type_: str, count: int = 1) -> dict[str, Any]:
        """The newest message of this type, once there are as many."""
        for _ in range(600):
            if len(found := self.all(type_)) >= count:
                return found[-1]
            self.page.wait_for_timeout(50)
        raise AssertionError(f"the page did not say {type_} {count} times: {self.heard}")

    def say(self, type_: str, **fields: Any) -> None:
        assert self._socket is not None
        self._socket.send(json.dumps({"type": type_, **fields}))

    def close(self, code: int, reason: str = "") -> None:
        assert self._socket is not None
        self._socket.close(code=code, reason=reason)

    def welcome(self, max_pixels: int = 3840 * 2160) -> None:
        """Answers the hello."""
        self.hear("hello")
        limits = {"max_pixels": max_pixels, "max_side": 16384, "window": 2, "max_message_bytes": 65536}
        schema = RenderSettings.model_json_schema()
        words = {"viewer": 1, "scenes": SCENES, "settings_schema": schema, "codecs": ["jpeg", "png", "h264"]}
        words["run"] = self.run
        words["gives_exports"] = self.gives_exports
        words["still_frames"] = {"draft": 2, "balanced": 16, "best": 64}
        self.say("welcome", protocol=PROTOCOL, limits=limits, takes_edits=self.takes_edits, **words)

    def scene(self, id_: str = "cornell-box", **more: Any) -> None:
        """Has the page enter a scene, of which there may be `more` to say; it answers with a pose."""
        bounds = {"min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]}
        parts = {"lights": [LAMP], "materials": [WALL], "objects": [{"id": "chair", "box": bounds}]}
        info = {"id": id_, "name": id_, "cameras": [FRONT], "bounds": bounds, "triangles": 36, **parts, **more}
        words = SceneInfo.model_validate(info).model_dump(mode="json", exclude={"type"})
        self.say("scene", **words)

    def start(self) -> None:
        """A page that has its first, moving picture of one colour."""
        self.welcome()
        self.scene()
        self.say("status", state="ready", text="", fraction=0.0)
        self.hear("pose")
        self.frame((64, 64, 64))

    def reload(self) -> None:
        """Loads the page anew and starts it."""
        before = self.connections
        self.page.reload()
        for _ in range(600):
            if self.connections > before:
                return self.start()
            self.page.wait_for_timeout(50)
        raise AssertionError("the page did not connect again")

    def frame(
        self,
        picture: tuple[int, int, int] | NDArray[np.uint8],
        size: tuple[int, int] = (64, 36),
        phase: Phase = Phase.MOVING,
        samples: tuple[int, int] = (1, 1),
        codec: Codec = Codec.JPEG,
        frame: int | None = None,
        stages: Mapping[str, float] = STAGES,
        broken: bool = False,
    ) -> int:
        """Sends a frame of the newest pose and settings: a colour, or pixels (height, width, 3); returns its id.

        H264 is a key frame where that is due. broken: the image's bytes are zeros.
        """
        pixels = np.empty((size[1], size[0], 3), np.uint8) if isinstance(picture, tuple) else picture
        if isinstance(picture, tuple):
            pixels[:] = picture
        self._frame = max(self._frame, frame or self._frame + 1)
        poses, settings = self.all("pose"), self.all("settings")
        if codec is Codec.PNG:
            image = encode_image(pixels, None, ".png")
        elif codec is Codec.H264:
            image, is_key = self._video.encode(1, self._frame, pixels)
            codec = Codec.H264_KEY if is_key else codec
        else:
            image = simplejpeg.encode_jpeg(np.ascontiguousarray(pixels), 90, "RGB", "444")
        header = FrameHeader(
            *(pixels.shape[1], pixels.shape[0], poses[-1]["id"] if poses else 0, frame or self._frame),
            *(settings[-1]["id"] if settings else 0, 0.4, sum(stages.values()), 0.3, stages),
            *(codec, phase, 100 if codec is Codec.PNG else 85, *samples),
        )
        if broken:
            image = bytes(len(image))
        assert self._socket is not None
        self._socket.send(header.pack() + image)
        return frame or self._frame


def visit(page: Page, service: Running) -> Stage:
    """The stage of a page that shows its first picture."""
    stage = Stage(page)
    page.goto(str(service.http.base_url))
    stage.start()
    expect(page.locator("body[data-picture]")).to_be_attached()
    return stage
