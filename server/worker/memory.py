"""How much memory a device has to give, before it is asked for: Linux promises more than there is, and kills for it."""

import re
from pathlib import Path
from resource import getpagesize

import warp as wp

_PROC = Path("/proc")
_CGROUPS = Path("/sys/fs/cgroup")
# Of a control group: what it may have, what it has, and what of that are files that can be read again.
_LIMITS = (
    ("memory.max", "memory.current", "inactive_file"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "total_inactive_file"),
)


def free_bytes(device: wp.Device) -> int:
    """What can be allocated on a device now; of a CPU, what the machine has, or the container if that is less."""
    if device.is_cuda:
        wp.synchronize_device(device)  # what was freed is given back then
        return int(device.free_memory)
    return free_host_bytes()


def own_bytes(proc: Path = _PROC) -> int:
    """What this process has of the machine's memory."""
    return int((proc / "self/statm").read_text().split()[1]) * getpagesize()


def free_host_bytes(proc: Path = _PROC, cgroups: Path = _CGROUPS) -> int:
    """What this process can get of the machine's memory, or of its container's."""
    found = re.search(r"MemAvailable:\s+(\d+) kB", (proc / "meminfo").read_text())
    free = int(found.group(1)) * 1024 if found else 0
    for limit, current, files in _LIMITS:
        try:
            most = int((cgroups / limit).read_text())
            used = int((cgroups / current).read_text())
            statistics = (cgroups / limit).with_name("memory.stat").read_text()
        except (OSError, ValueError):  # there is no such group, or "max"
            continue
        again = re.search(rf"^{files} (\d+)$", statistics, re.MULTILINE)
        free = min(free, max(most - used + (int(again.group(1)) if again else 0), 0))
    return free
