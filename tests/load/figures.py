"""Percentiles, jitter, fairness, slopes and the rows of tables: what logs say. Pure."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tests.load.viewer import Log, Seen

Row = dict[str, Any]
BUSY = 0.85  # a share of time above which something is the bottleneck
PARTS = ("queue", "render", "encode", "network", "decode")


@dataclass(frozen=True)
class Level:
    """The service that every viewer is to get. Ages in milliseconds, at the 95th percentile; None is not asked for."""

    fps: float = 10.0
    age: float = 100.0
    decoded: float | None = None

    def missed(self, row: Mapping[str, Any]) -> list[str]:
        """What of it a crowd's row does not meet, in words; nothing when all is met."""
        found = []
        for viewer in row["each"]:
            name = f"viewer {viewer['viewer']}"
            if viewer["fps"] < self.fps:
                found.append(f"{name}: {viewer['fps']:.1f} frames a second, not {self.fps:g}")
            for what, limit in (("age", self.age), ("decoded", self.decoded)):
                measured = viewer[what]["p95"] if viewer[what] else None
                if limit is not None and measured is not None and measured > limit:
                    found.append(f"{name}: p95 {what} {measured:.0f} ms, not {limit:g} ms")
        found += [f"{count} × {error}" for error, count in row["errors"].items()]
        return found


def spread(values: Sequence[float]) -> dict[str, float] | None:
    """Mean and percentiles; None of nothing."""
    if not values:
        return None
    p50, p95, p99 = np.percentile(values, (50, 95, 99))
    return {"mean": float(np.mean(values)), "p50": float(p50), "p95": float(p95), "p99": float(p99)}


def jitter(ages: Sequence[float]) -> float:
    """Mean absolute difference of consecutive ages: the D of RFC 3550, section 6.4.1, not smoothed."""
    return float(np.abs(np.diff(ages)).mean()) if len(ages) > 1 else 0.0


def fairness(shares: Sequence[float]) -> float:
    """R. Jain's index (1984): 1 when all get the same, 1/n when one of n gets all."""
    squares = len(shares) * sum(share * share for share in shares)
    return min(sum(shares) ** 2 / squares, 1.0) if squares else 1.0  # equal shares may round to more


@dataclass(frozen=True)
class Slope:
    """A straight line through measurements: what it gains a unit of x, and the standard error of that."""

    gain: float
    error: float

    @property
    def significant(self) -> bool:
        """Whether it is further from flat than chance would have it."""
        return abs(self.gain) > 3.0 * self.error


def slope(xs: ArrayLike, ys: ArrayLike, blocks: int = 20) -> Slope:
    """Least squares through means of up to `blocks` blocks: samples that follow each other are not independent."""
    x, y = np.asarray(xs, np.float64), np.asarray(ys, np.float64)
    count = min(blocks, len(x) // 2)
    if count < 3:
        return Slope(0.0, float("inf"))
    x, y = (np.array([block.mean() for block in np.array_split(values, count)]) for values in (x, y))
    spread_x = ((x - x.mean()) ** 2).sum()
    gain = float(((x - x.mean()) * (y - y.mean())).sum() / spread_x)
    rest = y - y.mean() - gain * (x - x.mean())
    return Slope(gain, float(np.sqrt((rest**2).sum() / (count - 2) / spread_x)))


def viewer_row(log: Log, since: float, until: float) -> Row:
    """One viewer between two times [s]. Frames a second count new poses only, not the sharper pictures of a rest."""
    seen = [one for one in log.seen if since <= one.at < until]
    fresh = [one for one in seen if one.arrived is not None]
    ages = [one.arrived for one in fresh if one.arrived is not None]
    gaps = [1e3 * (after.at - before.at) for before, after in pairwise(fresh)]
    seconds = until - since
    return {
        "viewer": log.number,
        "frames": len(seen),
        "fps": len(fresh) / seconds,
        "age": spread(ages),
        "decoded": spread([one.decoded for one in fresh if one.decoded is not None]),
        "jitter_ms": jitter(ages),
        "longest_gap_ms": max(gaps, default=1e3 * seconds),
        "bytes_a_second": sum(one.size for one in seen) / seconds,
        "width": float(np.mean([one.header.width for one in fresh])) if fresh else 0.0,
        "closed": log.closed,
    }


def crowd_row(logs: Sequence[Log], since: float, until: float, shares: Mapping[str, float]) -> Row:
    """All viewers between two times. shares: of the time that processes were busy, by name, beside the renderer's."""
    each = [viewer_row(log, since, until) for log in logs]
    seen = [one for log in logs for one in log.seen if since <= one.at < until]
    fresh = [one for one in seen if one.arrived is not None]
    errors: Counter[str] = Counter()
    for log in logs:
        errors.update(log.errors)
        if log.closed:
            errors[f"closed with {log.closed[0]}: {log.closed[1]}"] += 1
    row = {
        "viewers": len(logs),
        "seconds": until - since,
        "fps": {"mean": float(np.mean([one["fps"] for one in each])), "least": min(one["fps"] for one in each)},
        "age": spread([one.arrived for one in fresh if one.arrived is not None]),
        "decoded": spread([one.decoded for one in fresh if one.decoded is not None]),
        "jitter_ms": float(np.mean([one["jitter_ms"] for one in each])),
        "bytes_a_second": sum(one["bytes_a_second"] for one in each),
        "fairness": fairness([one["fps"] for one in each]),
        "width": float(np.mean([one["width"] for one in each])),
        "parts_ms": parts(fresh),
        "shares": {"renderer": sum(one.header.render_ms for one in seen) / 1e3 / (until - since), **shares},
        "errors": dict(errors),
        "each": each,
    }
    return row | {"bottleneck": bottleneck(row["parts_ms"], row["shares"])}


def parts(fresh: Sequence[Seen]) -> dict[str, float]:
    """Where the age of frames comes from, means in milliseconds; network is all that the server does not know of."""
    if not fresh:
        return {}
    headers = [one.header for one in fresh]
    means = {
        "queue": float(np.mean([header.queue_ms for header in headers])),
        "render": float(np.mean([header.render_ms for header in headers])),
        "encode": float(np.mean([header.encode_ms for header in headers])),
    }
    age = float(np.mean([one.arrived for one in fresh if one.arrived is not None]))
    decodes = [one.decode for one in fresh if one.decode is not None]
    return means | {"network": max(age - sum(means.values()), 0.0), "decode": float(np.mean(decodes or [0.0]))}


def bottleneck(means: Mapping[str, float], shares: Mapping[str, float]) -> str:
    """What to make faster first: what is busy nearly all the time, else what takes longest."""
    busy = max(shares, key=lambda name: shares[name], default="")
    if busy and shares[busy] >= BUSY:
        return f"{busy} (busy {100 * shares[busy]:.0f} %)"
    if not means:
        return "no frames"
    longest = max(means, key=lambda name: means[name])
    return f"{longest} ({means[longest]:.1f} ms of {sum(means.values()):.1f} ms)"


def table(rows: Sequence[Row]) -> str:
    """The rows of crowds for people."""
    titles = "viewers  fps  least  age p50   p95   p99  decoded p95  jitter  width   MB/s  fair  bottleneck"
    lines = [titles]
    for row in rows:
        age, decoded = row["age"] or {}, row["decoded"] or {}
        lines.append(
            f"{row['viewers']:7} {row['fps']['mean']:4.1f} {row['fps']['least']:6.1f}"
            f" {_ms(age, 'p50'):>8} {_ms(age, 'p95'):>5} {_ms(age, 'p99'):>5} {_ms(decoded, 'p95'):>12}"
            f" {row['jitter_ms']:7.1f} {row['width']:6.0f} {row['bytes_a_second'] / 1e6:6.2f}"
            f" {row['fairness']:5.2f}  {row['bottleneck']}"
        )
    return "\n".join(lines)


def _ms(figures: Mapping[str, float], name: str) -> str:
    return f"{figures[name]:.0f}" if name in figures else "-"
