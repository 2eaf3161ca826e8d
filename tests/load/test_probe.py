import asyncio
import os
import subprocess
import sys

from tests.load import probe
from tests.load.target import Target

METRICS = """# TYPE lumenwalk_frames counter
lumenwalk_frames_total{phase="moving"} 3.0
lumenwalk_frames_total{phase="final"} 1.0
# TYPE lumenwalk_viewers gauge
lumenwalk_viewers 2.0
"""


def test_metrics_are_read_by_name_and_labels() -> None:
    found = probe.read_metrics(METRICS)
    assert found == {
        'lumenwalk_frames_total{phase="moving"}': 3.0,
        'lumenwalk_frames_total{phase="final"}': 1.0,
        "lumenwalk_viewers": 2.0,
    }


def test_a_service_says_how_it_is(target: Target) -> None:
    async def ask() -> tuple[dict[str, object], dict[str, float]]:
        async with target.http() as http:
            return await probe.state(http), await probe.scrape(http)

    state, metrics = asyncio.run(ask())
    assert (state["code"], state["status"]) == (200, "ready")
    assert metrics["process_resident_memory_bytes"] > 1e6


def test_processes_are_found_and_measured_while_they_live() -> None:
    program = "block = bytearray(30_000_000); sum(range(10**6)); print(flush=True); input()"
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", program, "worker"], stdin=pipe, stdout=pipe) as child:
        assert child.stdout is not None
        child.stdout.readline()
        assert "worker" in probe.children(os.getpid())[child.pid]
        assert probe.rss_bytes(child.pid) > 30_000_000
        child.kill()
    assert child.pid not in probe.children(os.getpid())
    assert probe.rss_bytes(child.pid) == 0
