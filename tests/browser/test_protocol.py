"""The page's side of the wire against the server's own messages."""

import base64
from dataclasses import fields

import pytest
from harness import Running
from playwright.sync_api import Page

from server.wire.frame_header import HEADER_VERSION, LOSSLESS, Codec, FrameHeader, Phase
from tests.browser.message_types import FILE, text

PARSE = """async (frame) => {
  const { parseFrame } = await import("./protocol.js");
  const { image, ...fields } = parseFrame(Uint8Array.from(atob(frame), (byte) => byte.charCodeAt(0)).buffer);
  return { ...fields, image: [...image] };
}"""
# What the page calls a field of the header.
NAMES = {"target_samples": "targetSamples", "stage_ms": "stagesMs"} | {
    f"{part}_ms": f"{part}Ms" for part in ("queue", "render", "encode")
}


def test_the_types_of_messages_are_those_of_the_server() -> None:
    assert FILE.read_text() == text(), "run python -m tests.browser.message_types"


@pytest.fixture
def blank(page: Page, gradients: Running) -> Page:
    """A page beside the service's modules that runs none of them."""
    empty = '<!doctype html><title>blank</title><link rel="icon" href="data:,">'
    page.route("**/blank", lambda route: route.fulfill(body=empty, content_type="text/html"))
    page.goto(f"{gradients.http.base_url}/blank")
    return page


@pytest.mark.parametrize("codec", Codec)
@pytest.mark.parametrize("phase", Phase)
def test_the_page_reads_each_field_of_a_frame(blank: Page, codec: Codec, phase: Phase) -> None:
    stages = {"gbuffer": 0.5, "a stage of another method": 12.25}
    header = FrameHeader(640, 360, 7, 2**32 - 1, 3, 0.5, 12.25, 1.5, stages, codec, phase, 85, 3, 64)
    parsed = blank.evaluate(PARSE, base64.b64encode(header.pack() + b"image").decode())
    expected = {NAMES.get(field.name, field.name): getattr(header, field.name) for field in fields(FrameHeader)}
    expected |= {"codec": codec.name.lower(), "phase": phase.name.lower(), "image": list(b"image")}
    assert parsed == expected


def test_the_page_knows_the_same_constants(blank: Page) -> None:
    assert blank.evaluate("async () => (await import('./protocol.js')).LOSSLESS") == LOSSLESS
    header = FrameHeader(1, 1, 1, 1, 1, 0.0, 0.0, 0.0, {}).pack()
    for version in (HEADER_VERSION - 1, HEADER_VERSION + 1):
        frame = base64.b64encode(bytes([version]) + header[1:]).decode()
        with pytest.raises(Exception, match="not a frame"):
            blank.evaluate(PARSE, frame)
