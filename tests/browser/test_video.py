"""H.264 in a real browser: decoded in turn beside JPEGs, chosen by the user, and begun anew where it is broken."""

import numpy as np
from harness import Running
from looking import pixel, wait_for
from playwright.sync_api import Page, expect
from staged import visit

from server.wire.frame_header import Codec, Phase

RED, GREEN, GREY = (200, 0, 0), (0, 180, 0), (64, 64, 64)


def close(colour: tuple[int, int, int], expected: tuple[int, int, int]) -> bool:
    return all(abs(a - b) < 12 for a, b in zip(colour, expected, strict=True))


def test_pictures_of_a_video_follow_on_one_another_and_on_jpegs(page: Page, gradients: Running) -> None:
    stage = visit(page, gradients)
    for colour, size in ((RED, (64, 36)), (GREEN, (64, 36)), (RED, (33, 19)), (GREEN, (33, 19))):
        stage.frame(colour, size, codec=Codec.H264)
        wait_for(page, lambda wanted=colour: close(pixel(page), wanted))  # type: ignore[misc]
    assert page.evaluate("[document.getElementById('view').width, document.getElementById('view').height]") == [33, 19]
    assert close(pixel(page, 0.99, 0.99), GREEN)
    expect(page.locator("#codec")).to_have_text("H.264 video")
    stage.frame(GREY, phase=Phase.STILL, samples=(1, 8))
    wait_for(page, lambda: close(pixel(page), GREY))
    expect(page.locator("#codec")).to_have_text("JPEG 85")
    assert not any(ack.get("broken") for ack in stage.all("ack"))


def test_what_cannot_be_decoded_is_said_and_a_whole_picture_goes_on(page: Page, gradients: Running) -> None:
    stage = visit(page, gradients)
    stage.frame(RED, codec=Codec.H264)
    wait_for(page, lambda: close(pixel(page), RED))
    stage.frame(GREEN, codec=Codec.H264, broken=True)
    wait_for(page, lambda: bool(stage.all("ack")[-1].get("broken")))
    stage.frame(np.full((18, 32, 3), GREEN, np.uint8), codec=Codec.H264)  # of another size: whole
    wait_for(page, lambda: close(pixel(page), GREEN))
    assert not stage.all("ack")[-1].get("broken")


def test_the_user_chooses(page: Page, gradients: Running) -> None:
    stage = visit(page, gradients)
    before = len(stage.all("settings"))
    page.keyboard.press("KeyP")
    page.get_by_label("video while moving").select_option("always")
    assert stage.hear("settings", before + 1)["stream"]["video"] is True
    stage.frame(GREY)
    page.get_by_label("video while moving").select_option("never")
    assert stage.hear("settings", before + 2)["stream"]["video"] is False
