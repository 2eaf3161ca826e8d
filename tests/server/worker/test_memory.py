from pathlib import Path

import pytest
import warp as wp

from server.worker.memory import free_bytes, free_host_bytes, own_bytes

MEMINFO = "MemTotal:  9000 kB\nMemFree:  10 kB\nMemAvailable:   4000 kB\n"


@pytest.mark.parametrize(
    ("files", "free"),
    [
        ({}, 4000 * 1024),
        ({"memory.max": "max", "memory.current": "5", "memory.stat": ""}, 4000 * 1024),
        ({"memory.max": "9000", "memory.current": "5000", "memory.stat": "anon 1\ninactive_file 1000\n"}, 5000),
        ({"memory.max": "9000", "memory.current": "9500", "memory.stat": ""}, 0),
        ({"memory.max": str(2**40), "memory.current": "5", "memory.stat": ""}, 4000 * 1024),
        (
            {
                "memory/memory.limit_in_bytes": "9000",
                "memory/memory.usage_in_bytes": "5000",
                "memory/memory.stat": "inactive_file 1\ntotal_inactive_file 7\n",
            },
            4007,
        ),
    ],
)
def test_a_container_may_have_less_than_its_machine(tmp_path: Path, files: dict[str, str], free: int) -> None:
    (tmp_path / "meminfo").write_text(MEMINFO)
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert free_host_bytes(tmp_path, tmp_path) == free


def test_pages_are_as_large_as_this_machine_has_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "self").mkdir()
    (tmp_path / "self/statm").write_text("9000 30 20 1 0 10 0\n")
    monkeypatch.setattr("server.worker.memory.getpagesize", lambda: 65_536)
    assert own_bytes(tmp_path) == 30 * 65_536


def test_this_machine_has_memory() -> None:
    assert free_bytes(wp.get_device("cpu")) > 2**20
    assert own_bytes() > 2**20
