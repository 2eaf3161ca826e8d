"""How many replicas there are to be."""

import math
from typing import Any

TARGET_BUSY = 0.7  # share of the time in which devices are to work, on average
# One who walks alone takes what a device has: so it serves so many viewers at least before another device comes, which
# comes at the latest when it serves so many.
FEWEST_VIEWERS, MOST_VIEWERS = 4, 24


def wanted_replicas(busy: float, viewers: float) -> int:
    """By the share of the time in which devices work, and by viewers, each of all replicas together."""
    by_time, at_most = math.ceil(busy / TARGET_BUSY), math.ceil(viewers / FEWEST_VIEWERS)
    return max(min(by_time, at_most), math.ceil(viewers / MOST_VIEWERS), 1)


def scale(context: Any) -> tuple[int, dict[str, Any]]:
    """A policy for Ray Serve (its AutoscalingContext): by what replicas have said lately."""
    said = context.aggregated_metrics or {}
    busy, viewers = (sum(said.get(name, {}).values()) for name in ("busy", "viewers"))
    return wanted_replicas(busy, viewers), {}
