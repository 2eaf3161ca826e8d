"""Tables of what is left between measured times and floors, in Markdown."""

from collections import Counter

from tests.bench.rows import scenes_of
from tests.bench.store import Row
from tests.bench.tables import number, table

RATES = {
    "launches": "launches",
    "bytes": "bytes",
    "fmas": "multiply-adds",
    "any_hit_rays": "any-hit rays",
    "primary_rays": "primary rays",
}


def floors_table(rows: list[Row]) -> str:
    """Measured time, floor and their ratio of each stage, a column a scene; most left to the floor first."""
    stages = dict.fromkeys(stage for row in rows for stage in row["stages"])
    lines = []
    for stage in sorted(stages, key=lambda stage: -_left(rows, stage)):
        own = [row["stages"].get(stage, {}) for row in rows]
        bounds = Counter(RATES[times["bound"]] for times in own if "bound" in times)
        bound = bounds.most_common(1)[0][0] if bounds else "no model"
        lines.append([stage, bound, number(_left(rows, stage)), *(_floor_text([times]) for times in own)])
    whole = [_floor_text(list(row["stages"].values())) for row in rows]
    left = number(sum(_left(rows, stage) for stage in stages))
    return table(
        ["stage", "bound by", "left, mean [ms]", *scenes_of(rows)], [*lines, ["all with a model", "", left, *whole]]
    )


def _left(rows: list[Row], stage: str) -> float:
    """Mean time [ms] of a stage above its floor, over the scenes; 0 for one without a model."""
    own = [row["stages"].get(stage, {}) for row in rows]
    return sum(times["median"] - times["floor_ms"] for times in own if "floor_ms" in times) / len(rows)


def _floor_text(stages: list[Row]) -> str:
    stages = [times for times in stages if "floor_ms" in times]
    measured, floor = (sum(times[key] for times in stages) for key in ("median", "floor_ms"))
    return f"{number(measured)} / {number(floor)} ({measured / floor:.1f}×)" if floor else "–"


def terms_table(row: Row) -> str:
    """What the floors of one scene consist of."""
    lines = [
        [stage, term["what"], f"{number(term['amount'])} {RATES[term['rate']]}", number(term["ms"])]
        for stage, times in row["stages"].items()
        for term in times.get("terms", ())
    ]
    launches = [
        [stage, "launches", str(times["launches"]), number(times["launch_ms"])]
        for stage, times in row["stages"].items()
        if times.get("launches")
    ]
    return table(["stage", "what", "amount", "ms"], [*lines, *launches])


def rates_table(rows: list[Row]) -> str:
    """The rates that floors were computed with."""
    keys = {"any_hit_rays": 1e9, "primary_rays": 1e9, "bytes": 1e12, "fmas": 1e12, "launches": 1e6}
    head = ["scene", "any-hit rays [G/s]", "primary rays [G/s]", "bytes [T/s]", "multiply-adds [T/s]", "launches [M/s]"]
    return table(head, ([row["scene"], *(number(row["rates"][k] / unit) for k, unit in keys.items())] for row in rows))
