import os
from pathlib import Path

import pytest

from server.plain_files import read_plain


def test_a_plain_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"content")
    assert read_plain(file, 7) == b"content"
    with pytest.raises(ValueError, match="too large"):
        read_plain(file, 6)


def test_what_is_no_plain_file_is_not_read_nor_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/zero")
    for name in ("pipe", "link", ".", "gone"):
        with pytest.raises((OSError, ValueError)):
            read_plain(tmp_path / name, 100)
