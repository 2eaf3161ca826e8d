"""How fast each stage could be: what it cannot do without, over the rates of the machine. Pure.

A stage's floor is the largest of its terms, as if the others hid behind it, and its launches, which nothing hides. It
counts each byte once, as if caches were perfect, and each ray at the rate of rays that stay together.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import warp as wp

from gpu.gbuffer import GBuffer
from tests.bench.store import Row

# Issued instructions, each as dear as a multiply-add: a disk's light at a point (gpu.transfer.disk_irradiance), where
# a reciprocal counts four, and the stretched distance to a representative of like normal (gpu.grid.separation).
TRANSFER, SEPARATION = 20, 12
CELLS = 27
WORD = 32
VECTOR, NUMBER = 12, 4
GBUFFER = sum(wp.types.type_size_in_bytes(variable.type.dtype) for variable in GBuffer.vars.values())

Counts = Mapping[str, float]


@dataclass(frozen=True)
class Term:
    """An `amount` of something by a frame's counts, and the name in tests.bench.rates.Rates of how fast that goes."""

    what: str
    rate: str
    amount: Callable[[Counts], float]


def _pairs(n: Counts) -> float:
    return n["sp_clusters"] * n["vpl_clusters"]


STAGES: dict[str, tuple[Term, ...]] = {
    "gbuffer": (
        Term("a ray a pixel", "primary_rays", lambda n: n["pixels"]),
        Term("the G-buffer written", "bytes", lambda n: n["pixels"] * GBUFFER),
    ),
    "cluster": (
        Term(
            "SPs read, clusters and weights written",
            "bytes",
            lambda n: n["sps"] * (2 * VECTOR + 2 * NUMBER + 2 * NUMBER * n["fuzziness"]),
        ),
        Term("a distance in each of 27 cells an SP", "fmas", lambda n: n["sps"] * CELLS * SEPARATION),
    ),
    "visibility": (
        Term("rays between representatives", "any_hit_rays", lambda n: n["rays"]),
        Term("the light of every pair", "fmas", lambda n: _pairs(n) * TRANSFER),
        Term("a bit a pair written", "bytes", lambda n: _pairs(n) / 8),
    ),
    "shade": (
        Term("the light of every pair that sees each other", "fmas", lambda n: n["seen_pairs"] * TRANSFER),
        Term(
            "SPs and bits read, light written",
            "bytes",
            lambda n: _pairs(n) / 8 + n["sps"] * (5 * VECTOR + 2 * NUMBER * n["fuzziness"]),
        ),
    ),
    "check": (
        Term("a ray an SP", "any_hit_rays", lambda n: n["sps"]),
        Term("its target, one of 32", "fmas", lambda n: n["sps"] * WORD * TRANSFER),
    ),
    "refine": (
        Term(
            "a ray for 32 VPL clusters at each refined SP",
            "any_hit_rays",
            lambda n: n["refined"] * n["vpl_clusters"] / WORD,
        ),
        Term("the light of all their pairs", "fmas", lambda n: n["refined"] * n["vpl_clusters"] * TRANSFER),
    ),
    "display": (Term("radiance read, pixels written", "bytes", lambda n: n["pixels"] * (VECTOR + 3)),),
}


def floors(counts: Counts, rates: Mapping[str, float], launches: Mapping[str, int]) -> dict[str, Row]:
    """Each known stage's floor [ms], its terms, slowest first, and what its launches take."""
    result: dict[str, Row] = {}
    for stage, terms in STAGES.items():
        parts = []
        for term in terms:
            amount = float(term.amount(counts))
            rate = rates[term.rate]
            # What could not be measured, such as rays of a scene without VPLs, has no floor.
            ms = 1e3 * amount / rate if rate > 0.0 else 0.0
            parts.append({"what": term.what, "rate": term.rate, "amount": amount, "ms": ms})
        parts.sort(key=lambda part: part["ms"], reverse=True)
        number = launches.get(stage, 0)
        launch_ms = 1e3 * number / rates["launches"]
        result[stage] = {
            "floor_ms": parts[0]["ms"] + launch_ms,
            "terms": parts,
            "launches": number,
            "launch_ms": launch_ms,
        }
    return result
