"""What the service says of itself at /metrics and /readyz, and what Linux says of its processes."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx
from prometheus_client.parser import text_string_to_metric_families

TICK = os.sysconf("SC_CLK_TCK")


async def scrape(http: httpx.AsyncClient) -> dict[str, float]:
    """Every sample of /metrics, by its name with its labels; nothing where there is no such endpoint."""
    answer = await http.get("/metrics")
    return read_metrics(answer.text) if answer.status_code == 200 else {}


def read_metrics(text: str) -> dict[str, float]:
    """Samples of the Prometheus text format, as {'name{label="value"}': value}."""
    samples = [sample for family in text_string_to_metric_families(text) for sample in family.samples]
    return {sample.name + _labels(sample.labels): sample.value for sample in samples}


async def state(http: httpx.AsyncClient) -> dict[str, Any]:
    """What /readyz says, with its HTTP status as `code`."""
    answer = await http.get("/readyz")
    return {**answer.json(), "code": answer.status_code}


def children(pid: int) -> dict[int, str]:
    """Processes that `pid` has started and that live, by id, with their command lines."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and (fields := _stat(int(entry.name))) and int(fields[1]) == pid and fields[0] != "Z":
            found[int(entry.name)] = _command(int(entry.name))
    return found


def workers_of(pid: int) -> set[int]:
    """The renderers of the service `pid`, that live. They are named by what they run."""
    return {child for child, command in children(pid).items() if "worker" in command or "backend" in command}


def rss_bytes(pid: int) -> int:
    """Resident memory of a process; 0 when it is gone."""
    fields = _stat(pid)
    return int(fields[21]) * os.sysconf("SC_PAGE_SIZE") if fields else 0


def cpu_seconds(pid: int) -> float:
    """Processor time that a process has used; 0 when it is gone."""
    fields = _stat(pid)
    return (int(fields[11]) + int(fields[12])) / TICK if fields else 0.0


def _labels(labels: Mapping[str, str]) -> str:
    return "{" + ",".join(f'{name}="{value}"' for name, value in labels.items()) + "}" if labels else ""


def _stat(pid: int) -> list[str]:
    """Fields of /proc/PID/stat after the name, the first being the state."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def _command(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    except OSError:
        return ""
