"""How fast each stage could be: what it cannot do without, over the rates of the machine. Pure.

A stage's floor is what it must do of one thing, of that which takes longest, as if all else hid behind it; launches,
which nothing hides, come on top. Each byte counts once, as if caches were perfect; each ray as if rays stayed together.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import warp as wp

from gpu.correction.adaptive_rays import RAYS as BRIGHT_RAYS
from gpu.correction.outlier_shading import RAYS
from gpu.denoise.atrous import STEPS
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.irradiance import CHECKS
from gpu.vpl.vpl_clusters import LEAST_PER_GROUP
from tests.bench.store import Row

# Issued instructions, each as dear as a multiply-add: whether a point's normal and a disk's face each other; then the
# disk's light there (gpu.vpl.form_factor.disk_irradiance), where a reciprocal counts four; the stretched distance to a
# representative of like normal (gpu.clustering.grid.separation).
FACING, TRANSFER, SEPARATION = 9, 11, 12
CELLS = 27
VECTOR, NUMBER = 12, 4
# Without chains, where SPs seem to be is where they are, and most scenes have no sheen.
_LEFT_OUT = {"chains", "gloss", "traces_gloss", "grained", "translucent", "apparent", "sheen", "grain", "through"}
_ARRAYS = [variable.type.dtype for name, variable in GBuffer.vars.items() if name not in _LEFT_OUT]
GBUFFER = sum(wp.types.type_size_in_bytes(dtype) for dtype in _ARRAYS)

Counts = Mapping[str, float]
Floors = dict[str, Row]


@dataclass(frozen=True)
class Term:
    """An `amount` of something by a frame's counts, and the name in tests.bench.rates.Rates of how fast that goes."""

    what: str
    rate: str
    amount: Callable[[Counts], float]


def _pairs(n: Counts) -> float:
    return n["sp_clusters"] * n["vpl_clusters"]


# Positions, normals, a guide and the light read, and the light written, once beside each SP and at each step.
SMOOTHED = Term("light of SPs smoothed step by step", "bytes", lambda n: n["sps"] * (1 + len(STEPS)) * 5 * VECTOR)

STAGES: dict[str, tuple[Term, ...]] = {
    "gbuffer": (
        Term("a ray a pixel", "primary_rays", lambda n: n["pixels"]),
        Term("the G-buffer written", "bytes", lambda n: n["pixels"] * GBUFFER),
    ),
    "history": (Term("how many frames know an SP written", "bytes", lambda n: n["pixels"] * NUMBER),),
    "cluster": (
        Term(
            "SPs read, clusters and weights written",
            "bytes",
            lambda n: n["sps"] * (2 * VECTOR + 2 * NUMBER + 2 * NUMBER * n["fuzziness"]),
        ),
        Term("a distance in each of 27 cells an SP", "fmas", lambda n: n["sps"] * CELLS * SEPARATION),
        # These run beside, and slow down what they run beside.
        Term("near field: a ray an SP, as if rays stayed together", "primary_rays", lambda n: n["sps"]),
        Term("near field: rays from where those went to VPLs", "any_hit_rays", lambda n: n["near"]),
    ),
    "visibility": (
        Term("rays between representatives", "any_hit_rays", lambda n: n["rays"]),
        Term("which pairs face each other", "fmas", lambda n: _pairs(n) * FACING),
        Term("the light of those that do", "fmas", lambda n: _pairs(n) * n["facing"] * TRANSFER),
        Term("a bit a pair written", "bytes", lambda n: _pairs(n) / 8),
    ),
    "shade": (
        Term(
            "the light of far VPL clusters at representatives",
            "fmas",
            lambda n: _pairs(n) * (FACING + n["facing"] * TRANSFER),
        ),
        Term(
            "the light of near ones at SPs, and its visibility",
            "fmas",
            lambda n: n["near_pairs"] * (FACING + TRANSFER + n["fuzziness"]),
        ),
        Term(
            "SPs and two bits a pair of clusters read, light written",
            "bytes",
            lambda n: _pairs(n) / 4 + n["sps"] * (3 * VECTOR + 2 * NUMBER * n["fuzziness"]),
        ),
    ),
    "correct": (
        Term("rays of each SP, and again of suspects", "any_hit_rays", lambda n: (n["sps"] + n["suspected"]) * CHECKS),
        Term("beside: rays of SPs that may be brightest", "any_hit_rays", lambda n: n["bright"] * BRIGHT_RAYS),
        Term(
            "their targets, each one of a group",
            "fmas",
            lambda n: n["sps"] * CHECKS * LEAST_PER_GROUP * (FACING + n["facing"] * (TRANSFER + n["fuzziness"])),
        ),
        SMOOTHED,
        # This runs beside.
        replace(SMOOTHED, what="near field: light of SPs smoothed step by step"),
    ),
    "refine": (
        Term("rays of each refined SP", "any_hit_rays", lambda n: n["refined"] * RAYS),
        Term(
            "the light of all their pairs that face each other",
            "fmas",
            lambda n: n["refined"] * n["vpl_clusters"] * (FACING + n["facing"] * TRANSFER),
        ),
    ),
    "bright": (
        Term("what their rays found", "bytes", lambda n: n["bright"] * (2 * BRIGHT_RAYS * NUMBER + 5 * VECTOR)),
    ),
    "near": (Term("light of SPs added", "bytes", lambda n: n["sps"] * 3 * VECTOR),),
    "interpolate": (Term("surfaces, irradiance and radiance of pixels", "bytes", lambda n: n["pixels"] * 7 * VECTOR),),
    "keep": (
        Term("light of SPs kept", "bytes", lambda n: n["sps"] * 4 * VECTOR + n["pixels"] * 3 * NUMBER),
        Term("places and normals of all pixels kept", "bytes", lambda n: n["pixels"] * 4 * VECTOR),
    ),
    "display": (Term("radiance read, pixels written", "bytes", lambda n: n["pixels"] * (VECTOR + 3)),),
}


def floors(stages: Iterable[str], counts: Counts, rates: Mapping[str, float], launches: Mapping[str, int]) -> Floors:
    """Of those `stages` that have a model: the floor [ms], its terms, slowest first, and what launches take.

    counts: of a frame (FrameStats), `sps`, `fuzziness`, and `facing`, the share of pairs that face each other. A stage
    whose amounts a frame does not count has no floor.
    """
    result: Floors = {}
    for stage in STAGES.keys() & {*stages}:
        parts, totals = [], dict.fromkeys(rates, 0.0)
        try:
            amounts = [float(term.amount(counts)) for term in STAGES[stage]]
        except KeyError:
            continue
        for term, amount in zip(STAGES[stage], amounts, strict=True):
            # What could not be measured, such as rays of a scene without VPLs, has no floor.
            ms = 1e3 * amount / rates[term.rate] if rates[term.rate] > 0.0 else 0.0
            totals[term.rate] += ms
            parts.append({"what": term.what, "rate": term.rate, "amount": amount, "ms": ms})
        parts.sort(key=lambda part: part["ms"], reverse=True)
        number = launches.get(stage, 0)
        launch_ms = 1e3 * number / rates["launches"]
        result[stage] = {
            "floor_ms": max(totals.values()) + launch_ms,
            "bound": max(totals, key=lambda rate: totals[rate]),
            "terms": parts,
            "launches": number,
            "launch_ms": launch_ms,
        }
    return result
