import os
from contextlib import suppress

import pytest

from gpu.scene.formats.printed import printed_lines


def test_what_a_library_prints_is_kept_from_the_output(capfd: pytest.CaptureFixture[str]) -> None:
    with printed_lines() as lines:
        os.write(1, b"\x1b[31;1m*** a fault ***\n\x1b[0m\n\nmore")
        assert lines == []
    os.write(1, b"answer")
    assert lines == ["*** a fault ***", "more"]
    assert capfd.readouterr().out == "answer"


def test_more_than_a_pipe_holds_blocks_nobody() -> None:
    with printed_lines() as lines:
        for _ in range(100):
            with suppress(BlockingIOError):
                os.write(1, b"x" * 4000 + b"\n")
    assert 10 < len(lines) < 100


def test_the_output_is_given_back_after_an_error(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="broken"), printed_lines():
        raise ValueError("broken")
    os.write(1, b"answer")
    assert capfd.readouterr().out == "answer"
